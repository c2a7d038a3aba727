#include "leadthrough/guard/bridge.hpp"

#include <cmath>
#include <vector>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/guard/path_curve.hpp"
#include "leadthrough/time/jerk_filter.hpp"

namespace leadthrough::guard {

namespace {

using Eigen::Index;

// Each attempt takes longer than the one before by this fraction.
constexpr Index kFractions = 8;
constexpr double kNear = 1.0 + 1e-6;

// All joints from one state to another.
class Quintics {
 public:
  Quintics(const RowsRef& start, const RowsRef& end, double duration) {
    for (Index j = 0; j < start.cols() / 3; ++j)
      joints_.emplace_back(duration, joint_state(start, 0, j), joint_state(end, 0, j));
  }

  // Most attempts leave a limit by far, at a place like these.
  bool may_keep(const StepLimits& limits) const {
    for (const double fraction : {0.5, 0.2, 0.8})
      for (std::size_t j = 0; j < joints_.size(); ++j) {
        const JointState state = joints_[j].at(fraction);
        const auto joint = static_cast<Index>(j);
        if (std::abs(state.velocity) > limits.velocity[joint] * kNear ||
            std::abs(state.acceleration) > limits.acceleration[joint] * kNear)
          return false;
      }
    return true;
  }

  template <typename Row>
  void at(double fraction, Row row) const {
    for (std::size_t j = 0; j < joints_.size(); ++j)
      put(joints_[j].at(fraction), static_cast<Index>(j), row);
  }

 private:
  std::vector<JointQuintic> joints_;
};

// skip: rows of the target for each step after the first.
std::optional<Bridge> shortest(const StepLimits& limits, const RowsRef& start,
                               const RowsRef& target, Index most_steps, Index skip) {
  check_start(limits, start);
  check_states(limits, target, 1);
  check_argument(most_steps > 0 && most_steps <= kMaxBridge,
                 "most_steps: expected 1 to kMaxBridge");
  Rows stream(most_steps + 1, start.cols());
  stream.row(0) = start.row(0);
  for (Index steps = 1; steps <= most_steps; steps += 1 + steps / kFractions) {
    check_interrupt();
    const Index skipped = skip * (steps - 1);
    if (skipped >= target.rows()) break;
    const RowsRef landing = target.middleRows(skipped, 1);
    const double duration = static_cast<double>(steps) * limits.period;
    const Quintics quintics(start, landing, duration);
    if (!quintics.may_keep(limits)) continue;
    bool satisfied = true;
    for (Index k = 1; satisfied && k <= steps; ++k) {
      check_interrupt();
      if (k < steps)
        quintics.at(static_cast<double>(k) / static_cast<double>(steps), stream.row(k));
      else
        stream.row(k) = landing.row(0);
      satisfied = keeps(limits, stream, k);
    }
    if (satisfied) return Bridge{stream.middleRows(1, steps - 1), skipped};
  }
  return std::nullopt;
}

}  // namespace

std::optional<Bridge> bridge_to_start(const StepLimits& limits, const RowsRef& start,
                                      const RowsRef& target, Index most_steps) {
  return shortest(limits, start, target, most_steps, 0);
}

std::optional<Bridge> bridge_on_time(const StepLimits& limits, const RowsRef& start,
                                     const RowsRef& target, Index most_steps) {
  return shortest(limits, start, target, most_steps, 1);
}

namespace {

constexpr double kLeast = 0.02;   // of a limit that is left at least
constexpr double kFewest = 16.0;  // periods in which the acceleration rises to its limit
constexpr double kThere = 1e-9;   // rad or m, and their rates

// The part of a joint's limits that a target leaves in a step between two of its states.
AxisLimits left_of(const StepLimits& limits, Index joint, const JointState& from,
                   const JointState& to, double most_jerk, double use) {
  const auto left = [use](double limit, double used) {
    return std::max(use * limit - used, kLeast * limit);
  };
  const double v = limits.velocity[joint], a = limits.acceleration[joint], j = limits.jerk[joint];
  const double jerk = (to.acceleration - from.acceleration) / limits.period;
  // The limits of acceleration that are left move with the target's jerk.
  const double most =
      std::min(std::max(most_jerk, kLeast * j), a / (kFewest * limits.period)) + std::abs(jerk);
  return {-left(v, -to.velocity),          left(v, to.velocity),
          -left(a, -to.acceleration),      left(a, to.acceleration),
          -std::min(left(j, -jerk), most), std::min(left(j, jerk), most)};
}

}  // namespace

Rows joined(const StepLimits& limits, const RowsRef& start, const RowsRef& target,
            const Eigen::VectorXd& jerk, double use) {
  check_start(limits, start);
  check_states(limits, target, 1);
  check_argument(jerk.size() == limits.joints() && (jerk.array() >= 0.0).all(),
                 "jerk: expected one value a joint");
  check_argument(use > 0.0 && use <= 1.0, "use: expected a fraction");
  const Index last = target.rows() - 1;
  const bool rests = target.row(last).tail(2 * limits.joints()).isZero(0.0);
  const Index steps = rests ? std::max<Index>(0, last - 1) : last;
  Rows rows(steps + (rests ? kMaxJoin : 0), start.cols()), now = start;
  Rows away = start.row(0) - target.row(0);
  Index k = 0;
  const auto advance = [&](const RowsRef& from, const RowsRef& to) {
    check_interrupt(k);
    for (Index j = 0; j < limits.joints(); ++j) {
      const AxisLimits left =
          left_of(limits, j, joint_state(from, 0, j), joint_state(to, 0, j), jerk[j], use);
      put(step_axis(joint_state(away, 0, j), 0.0, left, limits.period), j, away.row(0));
    }
    rows.row(k++) = now = to + away;
  };
  while (k < steps) advance(target.middleRows(k, 1), target.middleRows(k + 1, 1));
  if (!rests) return rows;
  const RowsRef end = target.middleRows(last, 1);
  for (away = now - end; k < rows.rows() && (k == 0 || !away.isZero(kThere));) advance(end, end);
  return rows.topRows(k);
}

}  // namespace leadthrough::guard
