#pragma once

// Range of a joint's motion in one sample under position, velocity and acceleration limits, such
// that the next sample's box is never empty.

#include <algorithm>
#include <cmath>

#include "leadthrough/base/constants.hpp"

namespace leadthrough {

// The motion's clock around one interval between samples, s.
struct Interval {
  double duration = 0.0;
  double since_last = 0.0;  // from the middle of the interval before to the middle of this one
  double until_rest = 0.0;  // from the middle of this one to the middle of the rest after it
};

// The largest mean velocity over `duration` towards a wall `distance` away that still lets the
// joint brake before it. With changes of velocity of at most a (d + d') / 2 between intervals of d
// and d', (u + a d / 2)^2 <= 2 a distance holds in the next interval if it holds in this one and
// the joint brakes, whatever the next one's length: the ramp sampled at the intervals' middles.
inline double braking_velocity(double distance, double acceleration, double duration) {
  if (std::isinf(distance)) return distance;
  if (std::isinf(acceleration)) return distance / duration;
  const double most = std::sqrt(2.0 * acceleration * distance) - 0.5 * acceleration * duration;
  return std::max(most, 0.0);
}

struct Span {
  double lower, upper;
};

struct JointRates {
  double velocity, acceleration;
};

// Mean velocities allowed over `interval` to a joint that moved at `last` before it, with the
// position limits `room.lower` (<= 0) and `room.upper` away, braking
// before them with a part of the acceleration limit. Never empty if `last` was allowed.
inline Span allowed_velocities(const JointRates& limits, const Interval& interval, const Span& room,
                               double last, double part_of_braking) {
  const double change = limits.acceleration * interval.since_last;
  // 0 / 0 is no bound: an acceleration without limit stops the joint at once.
  const double rest =
      std::isinf(limits.acceleration) ? kInfinity : limits.acceleration * interval.until_rest;
  const double most = std::min(limits.velocity, rest);
  const double braking = part_of_braking * limits.acceleration;
  const double up = braking_velocity(room.upper, braking, interval.duration);
  const double down = braking_velocity(-room.lower, braking, interval.duration);
  const double upper = std::min({last + change, most, up});
  const double lower = std::max({last - change, -most, -down});
  return {std::min(lower, upper), upper};  // apart from rounding
}

}  // namespace leadthrough
