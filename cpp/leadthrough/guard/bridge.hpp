#pragma once

// Connecting motions from a stream's state onto target samples: the polynomial of degree 5 through
// the last three samples of the stream and the first three of the target, in the fewest periods
// that the limits allow.

#include "leadthrough/guard/step_limits.hpp"

namespace leadthrough::guard {

// samples: between the history and the target; skipped: rows of the target that the motion
// replaces.
struct Bridge {
  Rows samples;
  Eigen::Index skipped = 0;
};

// Onto the first row of the target (n, joints), n >= 3.
std::optional<Bridge> bridge_to_start(const StepLimits& limits, const RowsRef& history,
                                      const RowsRef& target, Eigen::Index most_steps);
// Onto the row that is due at arrival, as if the target's first row were due one period after the
// history.
std::optional<Bridge> bridge_on_time(const StepLimits& limits, const RowsRef& history,
                                     const RowsRef& target, Eigen::Index most_steps);

}  // namespace leadthrough::guard
