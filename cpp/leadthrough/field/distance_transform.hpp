#pragma once

// Exact Euclidean distance transform (Felzenszwalb and Huttenlocher 2012, "Distance transforms of
// sampled functions", section 2): the lower envelope of parabolas, axis by axis, in linear time.

#include <vector>

#include "leadthrough/field/grid.hpp"

namespace leadthrough {

// Distance from every cell to the nearest nonzero cell of `mask`, infinite if there is none.
std::vector<double> distance_transform(const Grid& grid, const std::uint8_t* mask);

}  // namespace leadthrough
