#pragma once

// Whether the samples of a motion keep their limits.

#include "base/matrix.hpp"
#include "time/rate_limits.hpp"

namespace leadthrough {

// A sampled motion. The arm stands still before the first sample and after the last, except where
// it passes that end.
struct SampledMotion {
  Eigen::Ref<const Eigen::VectorXd> times;  // s, at least one, increasing
  Eigen::Ref<const Rows> positions, velocities, accelerations;
  bool rests_at_start, rests_at_end;
};

// The most that a limit is used, beyond what the rounding of the positions makes of it.
struct LimitUse {
  Eigen::Index order = 0;  // 1 to 3, for velocity, acceleration and jerk
  Eigen::Index sample = 0, joint = 0;
  double ratio = 0.0;
};

// Of all divided differences of the positions, which are values that the derivatives of any smooth
// motion through them take, and of the velocities and accelerations given with them.
LimitUse largest_use(const SampledMotion& motion, const RateLimits& limits);

}  // namespace leadthrough
