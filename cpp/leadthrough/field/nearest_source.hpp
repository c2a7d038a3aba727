#pragma once

// Nearest of several sources to each cell, by arrival time.

#include <cstdint>
#include <vector>

#include "leadthrough/field/grid.hpp"

namespace leadthrough {

// Index in `sources` (cells) of the source whose front reached each cell first, by a field of
// arrival times that marched from all of them; -1 where the times are infinite or do not descend
// to a source.
std::vector<std::int32_t> nearest_sources(const Grid& grid, const double* arrival,
                                          const std::vector<Index>& sources);

}  // namespace leadthrough
