#pragma once

#include <array>
#include <vector>

namespace leadthrough {

using Point = std::array<double, 3>;

// Distances of points to the nearest of the points that a path is sampled at, or `most` where all
// are farther. They are found soonest where neighbours in `points` are neighbours in space.
std::vector<double> path_distances(const std::vector<Point>& points, const std::vector<Point>& path,
                                   double most);

}  // namespace leadthrough
