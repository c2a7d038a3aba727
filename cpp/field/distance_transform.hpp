#pragma once

// Exact Euclidean distance transform (Felzenszwalb and Huttenlocher 2012, "Distance transforms of
// sampled functions", section 2): the lower envelope of parabolas, axis by axis, in linear time.

#include <vector>

#include "field/grid.hpp"

namespace leadthrough {

// Distance from every cell to the nearest cell of `mask` that is not 0, infinite if there is none.
std::vector<double> distance_transform(const Grid& grid, const std::uint8_t* mask);

}  // namespace leadthrough
