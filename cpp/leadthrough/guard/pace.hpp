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

// Along a path (n, 3 joints) from its first row to its last, as slowly as the limits demand
// but in at most `most_samples`; exactly that many if even then a limit is exceeded.
std::optional<Paced> slowed(const StepLimits& limits, const RowsRef& path,
                            Eigen::Index most_samples);

// A stop on a path (n, 3 joints) that satisfies the limits after a state: as given up to the latest
// row from which it can stop at or before the last one.
std::optional<Paced> stopped(const StepLimits& limits, const RowsRef& start, const RowsRef& path);

}  // namespace leadthrough::guard
