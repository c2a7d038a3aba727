#pragma once

#include <array>
#include <vector>

namespace leadthrough {

using Point = std::array<double, 3>;

// Distances of points to the nearest sample of a path, at most `most`. Fastest if neighbours in
// `points` are neighbours in space.
std::vector<double> path_distances(const std::vector<Point>& points, const std::vector<Point>& path,
                                   double most);

}  // namespace leadthrough
