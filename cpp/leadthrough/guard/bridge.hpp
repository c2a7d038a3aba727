#pragma once

// Connecting motions from a state of a stream onto target samples: the polynomial of degree 5
// between the two states, in the fewest periods that the limits allow; or each joint by itself onto
// samples that pass meanwhile.

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

// A row a period, from the start on, along a target (n, 3 joints) whose first row is due at the
// start. Each joint ends its difference to it by the fastest way inside what the target leaves of
// a fraction of the limits, which are judged along the quintics between the rows, with at most a
// jerk beyond the target's own. If the last row is at rest, the way leads there from the last row
// but one, for kMaxJoin rows at most.
constexpr Eigen::Index kMaxJoin = 100'000;
Rows joined(const StepLimits& limits, const RowsRef& start, const RowsRef& target,
            const Eigen::VectorXd& jerk, double use);

}  // namespace leadthrough::guard
