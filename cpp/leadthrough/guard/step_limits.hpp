#pragma once

// A stream of commanded positions, one row a period. Velocity, acceleration and jerk are its
// differences of order 1 to 3: those of any smooth motion through the samples take these values.

#include <array>
#include <optional>

#include "leadthrough/base/matrix.hpp"

namespace leadthrough::guard {

using RowsRef = Eigen::Ref<const Rows>;

// One value a joint, finite and above zero but for the positions; rad or m per period, per period
// squared and cubed.
struct StepLimits {
  Eigen::VectorXd lower, upper;
  Eigen::VectorXd step, bend, twist;

  Eigen::Index joints() const { return step.size(); }
  const Eigen::VectorXd& difference(int order) const {
    return order == 1 ? step : order == 2 ? bend : twist;
  }
};

// The samples that the next differences reach back to, oldest first.
constexpr Eigen::Index kHistory = 3;

// First sample that exceeds a limit; order 0 is the position.
struct Excess {
  int order = 0;
  Eigen::Index sample = 0, joint = 0;
  double ratio = 0.0;
};

// Of samples (n, joints) that follow a history (3, joints) within the limits.
std::optional<Excess> first_excess(const StepLimits& limits, const RowsRef& history,
                                   const RowsRef& samples);

// True if row k >= kHistory of a stream satisfies the limits, given that the rows before it do.
inline bool keeps(const StepLimits& limits, const RowsRef& stream, Eigen::Index k) {
  return !first_excess(limits, stream.middleRows(k - kHistory, kHistory), stream.middleRows(k, 1));
}

// Factor by which each sample must be slowed down: the largest of the ratio to the limit of order
// 1, the square root of that of order 2 and the cube root of that of order 3; at most 1 where no
// limit is exceeded. Differences reach `kHistory` rows back; before the first row the motion is
// extrapolated linearly.
Eigen::VectorXd slowdowns(const StepLimits& limits, const RowsRef& samples);

}  // namespace leadthrough::guard
