#pragma once

// Ways from where a stream is onto samples that it is to go on with: the polynomial of degree 5
// through the last three samples and the first three of those, in the fewest periods that the
// limits allow.

#include "guard/step_limits.hpp"

namespace leadthrough::guard {

// samples: between the history and the target; skipped: rows of the target that are left out, as
// the way leads past them.
struct Bridge {
  Rows samples;
  Eigen::Index skipped = 0;
};

// Onto the first row of the target (n, joints), n >= 3.
std::optional<Bridge> bridge_to_start(const StepLimits& limits, const RowsRef& history,
                                      const RowsRef& target, Eigen::Index most_steps);
// Onto the row that is due by then, as if the target's first row were due a period after the
// history.
std::optional<Bridge> bridge_on_time(const StepLimits& limits, const RowsRef& history,
                                     const RowsRef& target, Eigen::Index most_steps);

}  // namespace leadthrough::guard
