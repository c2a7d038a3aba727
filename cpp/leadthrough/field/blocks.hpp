#pragma once

#include <array>
#include <optional>
#include <vector>

#include "leadthrough/field/cell_set.hpp"
#include "leadthrough/field/path_distance.hpp"

namespace leadthrough {

// Cubes of 2^level cells of a grid along each axis, counted from its first cell, as a coarser grid;
// the last ones may reach beyond the grid. At level 0 they are the cells.
struct Blocks {
  Grid grid;
  Point first;         // centre of the first along the grid's three axes
  int dimensions = 3;  // 2 for a flat grid
  int level = 0;
  double reach = 0.0;  // from a centre to the farthest centre of a block's cells

  Point centre(Index number) const { return centre_of(grid, first, number); }
  std::vector<Point> centres(const std::vector<Index>& numbers) const;
  std::array<Index, 3> place(Index number) const;  // along the three axes
  Index number(const std::array<Index, 3>& place) const;

  // The block that contains a point, if any.
  std::optional<Index> find(const Point& point) const;
};

// Blocks of cells, which are of level 0.
Blocks blocks_of(const Blocks& cells, int level);

// The block that holds a cell.
Index block_around(const Blocks& blocks, const Blocks& cells, Index cell);

}  // namespace leadthrough
