#pragma once

// The fastest stop of a stream, each joint by itself, with accelerations that are linear between
// samples: the quintics through these are then the cubics of that motion.
//
// Per period, a joint with velocity v and acceleration a comes to rest in m + 1 steps by
// accelerations a_1 ... a_m that add up to -d = -(v + a / 2), differ by at most the jerk limit J,
// from a_0 = a to a_{m+1} = 0, and are at most A. The lowest of them all at once,
//
//     low_i(m) = max(a - i J, -A, -(m + 1 - i) J),
//
// keeps these limits as each of the three does, and so does every mean of two that do. So m is the
// first number of steps whose lowest sum is -d or less, and the answer the mean of the lowest ones
// of m and of m - 1 steps that hits the sum: as fast as can be, and a continuous function of the
// state.

#include "leadthrough/guard/step_limits.hpp"

namespace leadthrough::guard {

// The samples (n, 3 joints) from a state (1, 3 joints) to rest, in the last of which all joints
// rest; none where they do already.
Rows brake(const StepLimits& limits, const RowsRef& start);

}  // namespace leadthrough::guard
