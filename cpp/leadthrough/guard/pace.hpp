#pragma once

// The same path at another pace: the curve through samples, slowed down or stopped.

#include <optional>

#include "leadthrough/guard/step_limits.hpp"

namespace leadthrough::guard {

// places: path parameter of each sample, in rows of the path.
struct Paced {
  Rows samples;
  Eigen::VectorXd places;
};

constexpr Eigen::Index kMaxPaced = 100'000'000;  // samples: a day at 1 kHz

// Along a path (n, 3 joints) from its first row to its last, as slowly as the limits demand
// but in at most `most_samples`; exactly that many if even then a limit is exceeded.
std::optional<Paced> slowed(const StepLimits& limits, const RowsRef& path,
                            Eigen::Index most_samples);

// A stop on a path (n, 3 joints) that satisfies the limits after a state: as given up to the latest
// row from which it can stop at or before the last one.
std::optional<Paced> stopped(const StepLimits& limits, const RowsRef& start, const RowsRef& path);

// Along a path (n, 3 joints) from a state at its first row's positions on: the pace changes as soon
// as the limits allow from that of the state, as far as it goes along the path, to `rate` rows a
// period. It ends before the first row at that rate that exceeds a limit.
std::optional<Paced> eased(const StepLimits& limits, const RowsRef& start, const RowsRef& path,
                           double rate);

}  // namespace leadthrough::guard
