#pragma once

#include <array>
#include <vector>

#include "field/cell_set.hpp"
#include "field/path_distance.hpp"

namespace leadthrough {

// Cubes of a grid's cells, or the cells themselves, as a coarser grid.
struct Blocks {
  Grid grid;
  Point first;   // centre of the first along the grid's three axes
  double reach;  // from a centre to the farthest centre of a block's cells, 0 for cells

  Point centre(Index number) const { return centre_of(grid, first, number); }
};

// A path that waves run fast about.
struct Tube {
  std::vector<Point> path;  // finely sampled
  double weight;            // in [0, 1], of the speed on the path
};

// Upper bounds of the speeds of the cells of blocks, and of cells the speeds themselves: they fall
// over the radius from each tube's weight, 1 being the speed limit, to the saturation.
std::vector<double> tube_speeds(const Blocks& blocks, const std::vector<Index>& numbers,
                                const std::vector<Tube>& tubes, double radius, double saturation);

}  // namespace leadthrough
