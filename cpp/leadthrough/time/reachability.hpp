#pragma once

#include <vector>

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

// Bounds on the motion along a path at the points of a grid over its parameter s. With the
// squared speed x = (ds/dt)^2 and the acceleration u = d2s/dt2 every row j says
// lower <= gain * u + bend * x <= upper. Joint accelerations read so with gain = dq/ds and
// bend = d2q/ds2, joint torques with what the dynamics make of them.
struct SpeedBounds {
  Eigen::VectorXd grid;     // (n,) increasing
  Eigen::VectorXd fastest;  // (n,) the largest x, finite, where velocities bind
  Rows gain, bend;          // (n, rows)
  Rows lower, upper;        // (n, rows) lower <= 0 <= upper lets the motion rest anywhere
};

enum class SpeedStatus { kOk, kNoMotion, kStartTooFast, kEndTooFast };

struct SpeedInterval {
  double low, high;
};

// The fastest motion: squared speeds at the grid's points, linear in s between them.
struct SpeedProfile {
  SpeedStatus status = SpeedStatus::kOk;
  Eigen::Index failed_at = -1;  // point of the grid where no motion is possible
  Eigen::VectorXd squared;      // (n,)
  // Those from which the rest of the path can be driven, (n,).
  std::vector<SpeedInterval> reach;
};

// Time-optimal squared speeds with x_start and x_end at the ends. A row holds at both ends of
// every cell, with the cell's own u (Pham & Pham 2018, the interpolation scheme).
// changed: (n,) at which points the bounds are others than those that `profile` was made of, where
// it was made of such bounds and the same ends; what does not change is not computed again. By
// default all are.
void fastest_profile(const SpeedBounds& bounds, double x_start, double x_end, SpeedProfile& profile,
                     const std::vector<char>& changed = {});

}  // namespace leadthrough
