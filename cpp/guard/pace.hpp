#pragma once

// The same path at another pace: a smooth curve through samples, run more slowly or to a stop.

#include <optional>

#include "guard/step_limits.hpp"

namespace leadthrough::guard {

// places: of each sample on the path, counted in its rows.
struct Paced {
  Rows samples;
  Eigen::VectorXd places;
};

// Along a path (n, joints), n >= 3, from its first row to its last, only as slowly as needed and no
// more slowly than in `most_samples`; that many where not even then.
std::optional<Paced> slowed(const StepLimits& limits, const RowsRef& path,
                            Eigen::Index most_samples);

// Along a path (n, joints) that keeps the limits behind its history, to rest on it: as given up to
// the latest row from which it can stop at or before the last one.
std::optional<Paced> stopped(const StepLimits& limits, const RowsRef& history, const RowsRef& path);

}  // namespace leadthrough::guard
