#pragma once

// A stream of commanded positions, one row a period. Velocity, acceleration and jerk are its
// differences of order 1 to 3: those of any smooth motion through the samples take these values.

#include <array>
#include <optional>

#include "base/matrix.hpp"

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

// Of samples (n, joints) that follow a history (3, joints) which keeps the limits.
std::optional<Excess> first_excess(const StepLimits& limits, const RowsRef& history,
                                   const RowsRef& samples);

// Whether row k of a stream keeps the limits, k >= kHistory, after rows that do.
inline bool keeps(const StepLimits& limits, const RowsRef& stream, Eigen::Index k) {
  return !first_excess(limits, stream.middleRows(k - kHistory, kHistory), stream.middleRows(k, 1));
}

// By which factor each sample would have to be passed more slowly: of the ratios to the limits of
// order 1 to 3 the first, the square root and the cube root, whichever is largest; at most 1 where
// no limit is exceeded. Differences reach `kHistory` rows back; the first rows count as if the
// motion had always gone on as between them.
Eigen::VectorXd slowdowns(const StepLimits& limits, const RowsRef& samples);

}  // namespace leadthrough::guard
