#include "leadthrough/ik/any_axes.hpp"

#include "leadthrough/ik/axis_task.hpp"

namespace leadthrough {

void evaluate(const Chain& chain, const IkTarget& target, const std::optional<IkAxes>& axes,
              const JointArray& q, TipError& error) {
  visit_target(target, axes, [&](auto dimension, const auto& seen) {
    constexpr int M = decltype(dimension)::value;
    Task<M> task;
    evaluate(chain, seen, q.data(), task);
    error.rows = task.rows;
    error.error.template head<M>() = task.error;
    for (std::size_t i = 0; i < static_cast<std::size_t>(chain.joints()); ++i)
      error.columns[i].template head<M>() = task.columns[i];
  });
}

bool settle(const Chain& chain, const IkTarget& target, const std::optional<IkAxes>& axes,
            const JointBox& bounds, const IkTolerance& tolerance, int max_iterations,
            JointArray& q) {
  return visit_target(target, axes, [&](auto dimension, const auto& seen) {
    constexpr int M = decltype(dimension)::value;
    PoseDescent<M, std::decay_t<decltype(seen)>> descent(chain, seen, bounds, q);
    if (!descent.task().within(tolerance)) descent.run(tolerance, max_iterations);
    q = descent.q();
    return descent.task().within(tolerance);
  });
}

}  // namespace leadthrough
