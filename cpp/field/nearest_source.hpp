#pragma once

// The source, of several, from which the front reached each cell.

#include <cstdint>
#include <vector>

#include "field/grid.hpp"

namespace leadthrough {

// For each cell the number of the source (its place in `sources`, cells) whose front reached it
// first, by a field of arrival times that marched from them all; -1 where the times do not lead
// down to a source, or are infinite.
std::vector<std::int32_t> nearest_sources(const Grid& grid, const double* arrival,
                                          const std::vector<Index>& sources);

}  // namespace leadthrough
