#pragma once

// Connecting motions from a state of a stream onto target samples: the polynomial of degree 5
// between the two states, in the fewest periods that the limits allow.

#include "leadthrough/guard/step_limits.hpp"

namespace leadthrough::guard {

// samples: between the start and the target; skipped: rows of the target that the motion replaces.
struct Bridge {
  Rows samples;
  Eigen::Index skipped = 0;
};

constexpr Eigen::Index kMaxBridge = 10'000'000;  // steps: hours at 1 kHz

// Onto the first row of the target (n, 3 joints).
std::optional<Bridge> bridge_to_start(const StepLimits& limits, const RowsRef& start,
                                      const RowsRef& target, Eigen::Index most_steps);
// Onto the row that is due at arrival, as if the target's first row were due one period after the
// start.
std::optional<Bridge> bridge_on_time(const StepLimits& limits, const RowsRef& start,
                                     const RowsRef& target, Eigen::Index most_steps);

}  // namespace leadthrough::guard
