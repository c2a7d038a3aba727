#pragma once

// The fastest motions along straight lines from rest to rest: the double S of bounded speed,
// acceleration and jerk (Biagiotti and Melchiorri 2008, Trajectory Planning for Automatic Machines
// and Robots, section 3.4).

#include <vector>

#include "leadthrough/time/quintic_step.hpp"
#include "leadthrough/time/rate_limits.hpp"

namespace leadthrough {

// Lines one after the other, with a rest of no time between them.
struct LineMotions {
  Eigen::Index failed_at = -1;      // line that would take the motion beyond the most samples
  std::vector<Eigen::Index> steps;  // of each line
  std::vector<JointState> shares;   // of its line, after each step, with derivatives by periods
};

// Lines from each of the points to the next, none of which repeats the one before. Samples a period
// apart and the quintics between them keep the limits. Joints with limits of 0 do not count.
LineMotions time_lines(const RowsRef& points, const RateLimits& limits, double period,
                       double longest);

}  // namespace leadthrough
