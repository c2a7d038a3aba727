#pragma once

// The fastest motion along a path inside velocity, acceleration and jerk limits.

#include <vector>

#include "leadthrough/time/path_grid.hpp"
#include "leadthrough/time/rate_limits.hpp"
#include "leadthrough/time/reachability.hpp"

namespace leadthrough {

// Further bounds at the points of the grid, by length and its derivatives in time; see SpeedBounds.
struct PathBounds {
  Eigen::VectorXd fastest;        // (points,) largest squared speed; may be infinite
  Rows gain, bend, lower, upper;  // (points, rows)
};

struct TimeLawOptions {
  double period = 1e-3;    // s, of the samples
  Eigen::Index parts = 1;  // samples for each one that the motion is given by
  // Speeds of the length at the ends; with 0 the motion starts and ends at rest.
  double start_speed = 0.0, end_speed = 0.0;
  double longest = 1e7;  // samples
  // A motion with bottlenecks is given up that is longer than its profile by so many times that and
  // its windows.
  double most_delay = 20.0;
};

enum class TimeLawStatus {
  kOk,
  kNoMotion,
  kStartTooFast,
  kEndTooFast,
  kTooLong,
  kNotSettled,
  kSlowProfile  // far longer than its bottlenecks are worth: rest at them
};

struct TimeLaw {
  TimeLawStatus status = TimeLawStatus::kOk;
  Eigen::Index failed_at = -1;  // point of the grid
  // Along the path at the times k * period, the last one at `duration`, with two derivatives.
  Eigen::VectorXd length, speed, push;
  double duration = 0.0;  // a multiple of the period where the motion ends at rest
  double optimum = 0.0;   // what it would be without jerk limits
  int rounds = 0;         // reachability passes
  // Points of the grid at which the motion has to be so much slower than beside them that it may
  // be faster to rest there. None where it is not much longer than its profile.
  std::vector<Eigen::Index> bottlenecks;
};

// The quintics through every one of `parts` samples keep the limits, see LimitRatios.
TimeLaw make_time_law(const PolynomialPath& path, const PathGrid& grid, const RateLimits& limits,
                      const PathBounds& bounds, const TimeLawOptions& options = {});

struct MotionStates {
  Rows positions, velocities, accelerations;
};

// The joints along the path at lengths with two derivatives in time, all (n).
MotionStates states_along(const PolynomialPath& path, const PathGrid& grid, const VectorRef& length,
                          const VectorRef& speed, const VectorRef& push);

}  // namespace leadthrough
