#include "leadthrough/ik/solve.hpp"

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/base/parallel.hpp"
#include "leadthrough/ik/axis_task.hpp"
#include "leadthrough/ik/configurations.hpp"
#include "leadthrough/ik/pose_search.hpp"
#include "leadthrough/ik/swept_self_motion.hpp"

namespace leadthrough {

namespace {

// Of these one descends to the closest configuration.
constexpr int kNearestOfSweep = 8;

// The search's best configuration, moved in the null space if requested.
template <int M, typename Target>
IkResult finish(PoseSearch<M, Target>& search, const Chain& chain, const IkOptions& options,
                const JointVector& start) {
  std::array<bool, kMaxJoints> limiting{};
  const IkStatus status = search.found() ? IkStatus::kConverged : search.come_close(limiting);
  const bool met = status == IkStatus::kConverged;
  if (met && options.posture) {
    search.take_turns_near(*options.posture);
    search.approach(towards(*options.posture), 1.0);
  } else if (met && options.nullspace_gain > 0.0 && search.redundant()) {
    search.take_turns_near(middle(chain));
    search.approach(towards_middle(chain), std::min(options.nullspace_gain, 1.0));
  } else {
    search.take_turns_near(start);
  }
  IkResult result = search.result(status);
  result.limiting = limiting;
  return result;
}

template <int M, typename Target>
IkResult solve_fastest(const Chain& chain, const Target& target, const IkOptions& options,
                       const JointVector& start, std::uint64_t stream) {
  PoseSearch<M, Target> search(chain, target, options, start, stream);
  while (search.attempt() && !search.found()) {
    check_interrupt();
  }
  return finish(search, chain, options, start);
}

template <int M, typename Target>
IkResult solve_closest(const Chain& chain, const Target& target, const IkOptions& options,
                       const JointVector& start, std::uint64_t stream) {
  const JointVector reference = options.reference.value_or(start);
  PoseSearch<M, Target> search(chain, target, options, start, stream);
  IkResult best;
  double least = kInfinity;
  while (search.attempt()) {
    check_interrupt();
    if (!search.found()) continue;
    search.take_turns_near(reference);
    search.approach(towards(reference), 1.0);
    const IkResult result = search.result(IkStatus::kConverged);
    const double distance = (result.q - reference).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    best = result;
  }
  if (least == kInfinity) return finish(search, chain, options, start);
  best.iterations = search.iterations();
  return best;
}

IkResult search(const Chain& chain, const IkTarget& target, const IkOptions& options,
                const JointVector& start, std::uint64_t stream) {
  return visit_target(target, options.axes, [&](auto dimension, const auto& seen) {
    constexpr int M = decltype(dimension)::value;
    using Target = std::decay_t<decltype(seen)>;
    return options.mode == IkMode::kClosest
               ? solve_closest<M, Target>(chain, seen, options, start, stream)
               : solve_fastest<M, Target>(chain, seen, options, start, stream);
  });
}

// The reason why there is no configuration, by the closed form, where the search found none.
void explain(const Configurations& all, IkResult& result) {
  if (all.uncertain || !all.found.empty()) return;
  const bool known = result.status == IkStatus::kLimits && all.status == IkStatus::kLimits;
  if (!known) result.limiting = all.limiting;
  result.status = all.status;
}

IkResult nearer(const IkResult& a, const IkResult& b, const JointVector& reference) {
  if (a.status != IkStatus::kConverged || b.status != IkStatus::kConverged)
    return a.status == IkStatus::kConverged ? a : b;
  return (a.q - reference).squaredNorm() <= (b.q - reference).squaredNorm() ? a : b;
}

}  // namespace

void check_options(const Chain& chain, const IkOptions& options, bool rotations) {
  for (const auto* each : {&options.reference, &options.posture})
    check_argument(!*each || (*each)->size() == chain.joints(),
                   "reference, posture: expected one value a joint");
  check_argument(!options.axes || options.axes->asked(rotations) > 0,
                 "axes: expected at least one that is not free");
}

JointVector project(const Chain& chain, const VectorRef& q) {
  check_argument(q.size() == chain.joints(), "q: expected one value a joint");
  JointVector inside(chain.joints());
  for (int i = 0; i < chain.joints(); ++i)
    inside[i] = wraps(chain, i) ? wrapped(q[i], q[i], chain.lower[i], chain.upper[i])
                                : std::clamp(q[i], chain.lower[i], chain.upper[i]);
  return inside;
}

JointVector middle(const Chain& chain) {
  JointVector centre(chain.joints());
  for (int i = 0; i < chain.joints(); ++i) {
    const double sum = 0.5 * chain.lower[i] + 0.5 * chain.upper[i];
    centre[i] = std::isfinite(sum) ? sum : std::clamp(0.0, chain.lower[i], chain.upper[i]);
  }
  return centre;
}

IkResult solve_ik(const Chain& chain, const IkTarget& target, const VectorRef& q0,
                  const IkOptions& options, std::uint64_t stream, const ClosedForm* form) {
  check_options(chain, options, target.rotation.has_value());
  const JointVector start = project(chain, q0);
  const bool closest = options.mode == IkMode::kClosest;
  const bool swept = closest && sweeps(form, target, options);
  if (!swept && !applies(form, target, options))
    return search(chain, target, options, start, stream);
  if (!closest) {
    IkResult result = search(chain, target, options, start, stream);
    if (result.status != IkStatus::kConverged)
      explain(all_configurations(chain, *form, target, start, options.tolerance), result);
    return result;
  }
  const JointVector reference = options.reference.value_or(start);
  const Configurations all =
      swept ? swept_configurations(chain, *form, target, reference, options.tolerance,
                                   kNearestOfSweep)
            : all_configurations(chain, *form, target, reference, options.tolerance);
  if (!all.found.empty() && !all.uncertain) return all.found.front();
  IkResult result = search(chain, target, options, start, stream);
  explain(all, result);
  return all.found.empty() ? result : nearer(all.found.front(), result, reference);
}

std::vector<IkResult> solve_ik_batch(const Chain& chain, const Rows3Ref& positions,
                                     const Rows4Ref& orientations, const RowsRef& starts,
                                     const IkOptions& options, int threads, const ClosedForm* form,
                                     Restarts restarts) {
  check_argument(orientations.rows() == positions.rows() || orientations.rows() == 0,
                 "orientations: expected a row for each position, or none");
  check_argument(starts.rows() == positions.rows() && starts.cols() == chain.joints(),
                 "starts: expected a row for each position and one value a joint");
  check_options(chain, options, orientations.rows() > 0);
  const auto count = static_cast<std::size_t>(positions.rows());
  std::vector<IkResult> results(count);
  for_each_index(count, threads, [&](std::size_t i) {
    const auto row = static_cast<Eigen::Index>(i);
    const JointVector q0 = starts.row(row);
    const std::uint64_t stream = restarts == Restarts::kAlike ? 0 : i;
    results[i] =
        solve_ik(chain, target_in_row(positions, orientations, row), q0, options, stream, form);
  });
  return results;
}

}  // namespace leadthrough
