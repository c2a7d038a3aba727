#include "time/line_law.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"

namespace leadthrough {

namespace {

using Eigen::Index;

// Rounding of a number of samples, of which the next whole one is taken.
constexpr double kCountRounding = 1e-9;
// Third differences of samples reach over so many periods, and see three quarters of a jump of the
// acceleration, or twice that of one from full to full the other way.
constexpr double kReach = 3.0;

// Limits of the share of a line that is covered, by period; infinite where there is none.
struct LineLimits {
  double speed, acceleration, jerk;

  // Whether differences of these sizes, of orders 1 to 3, are allowed.
  bool keep(double first, double second, double third) const {
    return first <= speed && second <= acceleration && third <= jerk;
  }
};

// Those of the joints, for a line from a point to the next.
LineLimits limits_along(const Eigen::Ref<const Rows>& points, Index line, const RateLimits& limits,
                        double period) {
  LineLimits least{kInfinity, kInfinity, kInfinity};
  for (Index j = 0; j < points.cols(); ++j) {
    const double motion = std::abs(points(line + 1, j) - points(line, j));
    if (motion == 0.0 || limits.velocity[j] == 0.0) continue;
    const double share = period / motion;
    least.speed = std::min(least.speed, limits.velocity[j] * share);
    least.acceleration = std::min(least.acceleration, limits.acceleration[j] * period * share);
    least.jerk = std::min(least.jerk, limits.jerk[j] * period * period * share);
  }
  return least;
}

// A jump from 0 to 1, averaged over three windows of time, in periods: the inverse of the first is
// the speed, that of the product of two the acceleration, and that of all three the jerk. None is
// shorter than the next, and the first is no shorter than the others together.
class DoubleS {
 public:
  explicit DoubleS(const LineLimits& limits) {
    choose(limits);
    steps_ = std::max(1.0, std::ceil(time() - kCountRounding));
    // A jump in one step, or two, has differences that the windows do not tell.
    if (steps_ > 1.0 && limits.keep(1.0, 1.0, 2.0)) steps_ = 1.0;
    if (steps_ > 2.0 && limits.keep(0.5, 0.5, 0.5)) steps_ = 2.0;
    const double slower = steps_ / time();  // to a whole number of periods
    for (double* window : {&speed_, &acceleration_, &jerk_}) *window *= slower;
  }

  double steps() const { return steps_; }

  double share(double time) const {
    return time > 0.5 * steps_ ? 1.0 - rise(steps_ - time) : rise(time);
  }

 private:
  double time() const { return speed_ + acceleration_ + jerk_; }

  void choose(const LineLimits& limits) {
    const double ramp = std::isinf(limits.jerk) ? 0.0 : limits.acceleration / limits.jerk;
    const double speed = 1.0 / limits.speed, climb = limits.speed / limits.acceleration;
    const double peak = std::sqrt(1.0 / limits.acceleration);
    // Samples do not see so short a ramp: third differences keep the limit without one.
    const bool apart = climb >= kReach && speed >= climb + kReach;
    if (ramp <= 0.5 || (ramp <= 1.0 && apart))
      set(std::max(speed, peak), std::min(climb, peak), 0.0);
    else if (climb >= ramp && speed >= climb + ramp)
      set(speed, climb, ramp);
    else
      choose_curved(limits, ramp);
  }

  // The limit of speed, that of acceleration, or neither is reached.
  void choose_curved(const LineLimits& limits, double ramp) {
    const double speed = 1.0 / limits.speed, root = std::sqrt(limits.speed / limits.jerk);
    if (root <= ramp && speed >= 2.0 * root) return set(speed, root, root);
    const double half = 0.5 * ramp;
    const double climb = std::sqrt(1.0 / limits.acceleration + half * half) - half;
    if (climb >= ramp) return set(climb + ramp, climb, ramp);
    const double cube = std::cbrt(0.5 / limits.jerk);
    set(2.0 * cube, cube, cube);
  }

  void set(double speed, double acceleration, double jerk) {
    speed_ = speed;
    acceleration_ = acceleration;
    jerk_ = jerk;
  }

  // The share that is covered on the way to full speed, and at it.
  double rise(double time) const {
    const double ramp = acceleration_ + jerk_, left = ramp - time;
    const double cube = 6.0 * speed_ * acceleration_ * jerk_;
    if (left <= 0.0) return (time - 0.5 * ramp) / speed_;
    if (time < jerk_) return time * time * time / cube;
    if (left < jerk_) return (time - 0.5 * ramp) / speed_ + left * left * left / cube;
    const double middle = time - 0.5 * jerk_;
    return (12.0 * middle * middle + jerk_ * jerk_) / (24.0 * speed_ * acceleration_);
  }

  double speed_ = 0.0, acceleration_ = 0.0, jerk_ = 0.0, steps_ = 0.0;
};

}  // namespace

LineMotions time_lines(const Eigen::Ref<const Rows>& points, const RateLimits& limits,
                       double period, Index parts, double longest) {
  LineMotions motions;
  double samples = 0.0;
  for (Index i = 0; i + 1 < points.rows(); ++i) {
    const DoubleS law(limits_along(points, i, limits, period));
    samples += law.steps();
    if (!(samples < longest)) {
      motions.failed_at = i;
      return motions;
    }
    const auto steps = static_cast<Index>(std::ceil(law.steps() / static_cast<double>(parts)));
    motions.steps.push_back(steps);
    for (Index k = 1; k <= steps; ++k)
      motions.shares.push_back(law.share(std::min(static_cast<double>(k * parts), law.steps())));
  }
  return motions;
}

}  // namespace leadthrough
