#include "leadthrough/time/line_law.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/time/limit_use.hpp"

namespace leadthrough {

namespace {

using Eigen::Index;

// Rounding of a number of samples, of which the next whole one is taken.
constexpr double kCountRounding = 1e-9;
// Third differences reach over so many periods, and carry this much rounding.
constexpr double kReach = 3.0, kDifferenceRounding = 1e-15;

// Limits of the share of a line that is covered, by period; infinite where there is none.
struct LineLimits {
  double speed, acceleration, jerk;
};

// Those of the joints, for a line from a point to the next.
LineLimits limits_along(const RowsRef& points, Index line, const RateLimits& limits,
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
struct DoubleS {
  double speed, acceleration, jerk;

  double time() const { return speed + acceleration + jerk; }

  // Of the share that is covered.
  JointState at(double time) const {
    if (time <= 0.5 * this->time()) return rise(time);
    const JointState back = rise(this->time() - time);
    return {1.0 - back.position, back.velocity, -back.acceleration};
  }

  DoubleS slower(double factor) const {
    return {factor * speed, factor * acceleration, factor * jerk};
  }

  // Its jerk then changes at samples only, and the quintics between them are the motion itself.
  DoubleS in_whole_periods() const {
    const auto whole = [](double window) {
      return std::max(1.0, std::ceil(window - kCountRounding));
    };
    DoubleS result{whole(speed), whole(acceleration), whole(jerk)};
    result.speed = std::max(result.speed, result.acceleration + result.jerk);
    return result;
  }

 private:
  JointState rise(double time) const {
    const double ramp = acceleration + jerk, left = ramp - time,
                 push = 1.0 / (speed * acceleration);
    if (left <= 0.0) return {(time - 0.5 * ramp) / speed, 1.0 / speed, 0.0};
    const double change = jerk > 0.0 ? push / jerk : 0.0;
    if (time < jerk)
      return {change * time * time * time / 6.0, 0.5 * change * time * time, change * time};
    if (left < jerk)
      return {(time - 0.5 * ramp) / speed + change * left * left * left / 6.0,
              1.0 / speed - 0.5 * change * left * left, change * left};
    const double middle = time - 0.5 * jerk;
    return {0.5 * push * (middle * middle + jerk * jerk / 12.0), push * middle, push};
  }
};

// Sums of as many samples are exact.
constexpr double kMaxSamples = 1e8;

// The fastest one for any times, not only those of samples.
DoubleS fastest(const LineLimits& limits) {
  const double ramp = std::isinf(limits.jerk) ? 0.0 : limits.acceleration / limits.jerk;
  const double speed = 1.0 / limits.speed, climb = limits.speed / limits.acceleration;
  if (climb >= ramp && speed >= climb + ramp) return {speed, climb, ramp};
  // The limit of speed, that of acceleration, or neither is reached.
  const double root = std::sqrt(limits.speed / limits.jerk);
  if (climb <= ramp && speed >= 2.0 * root) return {speed, root, root};
  const double half = 0.5 * ramp;
  const double most = std::sqrt(1.0 / limits.acceleration + half * half) - half;
  if (most >= ramp) return {most + ramp, most, ramp};
  const double cube = std::cbrt(0.5 / limits.jerk);
  return {2.0 * cube, cube, cube};
}

// Whether the quintics between samples keep the limits, and differences of the acceleration over a
// step and of the share over three.
bool keeps(const DoubleS& law, double steps, const LineLimits& limits) {
  const double allowed = 1.0 + kAllowedExcess;
  JointState last{0.0, 0.0, 0.0};
  double slope = 0.0, bend = 0.0;
  for (double time = 1.0; time < steps + kReach; time += 1.0) {
    check_interrupt();
    const JointState now = time < steps ? law.at(time) : JointState{1.0, 0.0, 0.0};
    const QuinticStep step(1.0, last, now);
    const double next = now.position - last.position, turn = next - slope;
    const double jerk = std::max(std::abs(now.acceleration - last.acceleration),
                                 std::abs(turn - bend) - kDifferenceRounding);
    const double speed = allowed * limits.speed, acceleration = allowed * limits.acceleration;
    if (jerk > allowed * limits.jerk ||
        (step.speed_bound() > speed && step.speed().value > speed) ||
        (step.acceleration_bound() > acceleration && step.acceleration().value > acceleration))
      return false;
    last = now;
    slope = next;
    bend = turn;
  }
  return true;
}

// The fastest one whose samples keep the limits: over a whole number of periods, or in windows of
// whole periods where the quintics would need more.
DoubleS sampled(const LineLimits& limits) {
  const DoubleS law = fastest(limits), whole = law.in_whole_periods();
  for (double steps = std::max(1.0, std::ceil(law.time() - kCountRounding)); steps < whole.time();
       steps += 1.0) {
    const DoubleS slower = law.slower(steps / law.time());
    if (keeps(slower, steps, limits)) return slower;
  }
  return whole;
}

}  // namespace

LineMotions time_lines(const RowsRef& points, const RateLimits& limits, double period,
                       double longest) {
  check_argument(limits.velocity.size() == points.cols() &&
                     limits.acceleration.size() == points.cols() &&
                     limits.jerk.size() == points.cols(),
                 "limits: expected one value a joint");
  check_argument(points.allFinite(), "points: finite");
  check_argument(period > 0.0 && longest <= kMaxSamples, "period: > 0; longest: at most 1e8");
  LineMotions motions;
  double samples = 0.0;
  for (Index i = 0; i + 1 < points.rows(); ++i) {
    check_interrupt();
    const LineLimits along = limits_along(points, i, limits, period);
    samples += fastest(along).time();
    if (!(samples < longest)) {
      motions.failed_at = i;
      return motions;
    }
    const DoubleS law = sampled(along);
    const double steps = std::round(law.time());
    motions.steps.push_back(static_cast<Index>(steps));
    for (double time = 1.0; time < steps; time += 1.0) motions.shares.push_back(law.at(time));
    motions.shares.push_back({1.0, 0.0, 0.0});
  }
  return motions;
}

}  // namespace leadthrough
