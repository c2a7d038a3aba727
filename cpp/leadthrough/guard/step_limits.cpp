#include "leadthrough/guard/step_limits.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "leadthrough/base/argument.hpp"

namespace leadthrough::guard {

namespace {

using Eigen::Index;

// Less than the tolerance of limit checks, 1e-6.
constexpr double kExcess = 0.999e-6;
// Positions may be this far beyond a limit, rad or m: a file's digits.
constexpr double kRounding = 1e-9;

// By how many times a step uses the limits of order 1 to 3; a larger number than that only where
// the limit is kept.
using Use = std::array<double, 3>;

Use use_of(const StepLimits& limits, Index joint, const QuinticStep& quintic,
           const JointState& from, const JointState& to) {
  const double velocity = limits.velocity[joint], acceleration = limits.acceleration[joint];
  Use use{quintic.speed_bound() / velocity, quintic.acceleration_bound() / acceleration,
          std::abs(to.acceleration - from.acceleration) / (limits.period * limits.jerk[joint])};
  if (!(use[0] <= 1.0)) use[0] = quintic.speed().value / velocity;
  if (!(use[1] <= 1.0)) use[1] = quintic.acceleration().value / acceleration;
  return use;
}

// At least the use of the limits of order 1 and 2, and hardly more.
Use bound_of(const StepLimits& limits, Index joint, const QuinticStep& quintic) {
  const double limit = limits.acceleration[joint];
  double acceleration = quintic.acceleration_bound();
  if (!(acceleration <= limit)) acceleration = quintic.acceleration().value;
  return {quintic.speed_bound() / limits.velocity[joint], acceleration / limit, 0.0};
}

// A check of limits takes a range by its half.
double rounding(double lower, double upper) {
  const double half = 0.5 * (upper - lower);
  return std::isfinite(half) ? std::min(kRounding, kExcess * half) : 0.0;
}

// The position outside of the limits, in the step to a state.
std::optional<double> outside(const StepLimits& limits, Index joint, const QuinticStep& quintic,
                              const JointState& from, const JointState& to) {
  const double beyond = rounding(limits.lower[joint], limits.upper[joint]);
  const double low = limits.lower[joint] - beyond, high = limits.upper[joint] + beyond;
  if (!(to.position >= low && to.position <= high)) return to.position;
  const double reach = limits.period * quintic.speed_bound();
  if (std::max(from.position, to.position) + reach > high) {
    const double highest = quintic.highest().value;
    if (!(highest <= high)) return highest;
  }
  if (std::min(from.position, to.position) - reach < low) {
    const double lowest = quintic.lowest().value;
    if (!(lowest >= low)) return lowest;
  }
  return std::nullopt;
}

// Row k of the start and the samples after it.
struct Stream {
  const RowsRef& start;
  const RowsRef& samples;

  JointState operator()(Index k, Index joint) const {
    return k < 0 ? joint_state(start, 0, joint) : joint_state(samples, k, joint);
  }
};

std::optional<Excess> excess_at(const StepLimits& limits, const Stream& stream, Index k,
                                Index joint) {
  const JointState from = stream(k - 1, joint), to = stream(k, joint);
  const QuinticStep quintic(limits.period, from, to);
  if (const auto position = outside(limits, joint, quintic, from, to))
    return Excess{0, k, joint, *position};
  const Use use = use_of(limits, joint, quintic, from, to);
  for (int order = 1; order <= 3; ++order) {
    const double ratio = use[static_cast<std::size_t>(order - 1)];
    if (!(ratio <= 1.0 + kExcess)) return Excess{order, k, joint, ratio};
  }
  return std::nullopt;
}

}  // namespace

void check_limits(const StepLimits& limits) {
  check_argument(limits.joints() > 0 && limits.lower.size() == limits.joints() &&
                     limits.upper.size() == limits.joints(),
                 "lower, upper: expected one value a joint");
  for (const Eigen::VectorXd* rates : {&limits.velocity, &limits.acceleration, &limits.jerk})
    check_argument(rates->size() == limits.joints() && (rates->array() > 0.0).all(),
                   "limits: expected one value above zero a joint");
  check_argument(limits.period > 0.0, "period: expected a positive time");
}

void check_start(const StepLimits& limits, const RowsRef& start) {
  check_argument(start.cols() == 3 * limits.joints() && start.rows() == 1 && start.allFinite(),
                 "start: expected one finite state of all joints");
}

void check_states(const StepLimits& limits, const RowsRef& rows, Index least) {
  check_argument(rows.cols() == 3 * limits.joints() && rows.rows() >= least,
                 "states: expected positions, velocities and accelerations of all joints");
}

std::optional<Excess> first_excess(const StepLimits& limits, const RowsRef& start,
                                   const RowsRef& samples) {
  check_start(limits, start);
  check_states(limits, samples, 0);
  const Stream stream{start, samples};
  for (Index k = 0; k < samples.rows(); ++k)
    for (Index joint = 0; joint < limits.joints(); ++joint)
      if (const auto found = excess_at(limits, stream, k, joint)) return found;
  return std::nullopt;
}

namespace {

// The factor that the largest uses of limits ask for. Roots are the most expensive part, and few
// rows need them.
double factor(const Use& use) {
  const double most = std::max({use[0], use[1], use[2]});
  return most > 1.0 ? std::max({use[0], std::sqrt(use[1]), std::cbrt(use[2])}) : most;
}

// By the states alone, without the quintics between them.
Eigen::VectorXd factors_at(const StepLimits& limits, const RowsRef& samples) {
  const Index joints = limits.joints();
  const Eigen::ArrayXd velocity = limits.velocity.array().inverse(),
                       acceleration = limits.acceleration.array().inverse(),
                       jerk = (limits.period * limits.jerk.array()).inverse();
  Eigen::VectorXd result = Eigen::VectorXd::Zero(samples.rows());
  for (Index k = 1; k < samples.rows(); ++k) {
    const auto rates = samples.row(k).transpose().array();
    const auto a = rates.tail(joints);
    const auto before = samples.row(k - 1).transpose().array().tail(joints);
    result[k] =
        factor({(rates.segment(joints, joints).abs() * velocity).maxCoeff(),
                (a.abs() * acceleration).maxCoeff(), ((a - before).abs() * jerk).maxCoeff()});
  }
  return result;
}

Eigen::VectorXd factors_between(const StepLimits& limits, const RowsRef& samples) {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(samples.rows());
  for (Index k = 1; k < samples.rows(); ++k) {
    Use most{};
    for (Index j = 0; j < limits.joints(); ++j) {
      const QuinticStep quintic(limits.period, joint_state(samples, k - 1, j),
                                joint_state(samples, k, j));
      const Use use = bound_of(limits, j, quintic);
      for (std::size_t order = 0; order < 2; ++order)
        most[order] = std::max(most[order], use[order]);
    }
    result[k] = factor(most);
  }
  return result;
}

}  // namespace

Eigen::VectorXd slowdowns(const StepLimits& limits, const RowsRef& samples) {
  const Eigen::VectorXd result = factors_at(limits, samples);
  if (result.size() == 0 || !(result.maxCoeff() <= 1.0)) return result;
  return factors_between(limits, samples);
}

}  // namespace leadthrough::guard
