#pragma once

// Cells of grids as they come from Python.

#include <pybind11/numpy.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bind/parts.hpp"
#include "leadthrough/field/cell_set.hpp"

namespace leadthrough {

// Count of cells whose computation takes longer than releasing and taking the GIL.
constexpr pybind11::ssize_t kManyCells = 1000;

// A 2D grid gets a first axis of one cell.
inline Grid grid_of(const std::vector<Index>& shape, const std::vector<double>& spacing) {
  require((shape.size() == 2 || shape.size() == 3) && spacing.size() == shape.size());
  Grid grid;
  const std::size_t lead = 3 - shape.size();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (axis >= lead) grid.shape[axis] = shape[axis - lead];
    grid.spacing[axis] = spacing[axis < lead ? 0 : axis - lead];
    require(grid.shape[axis] > 0 && std::isfinite(grid.spacing[axis]) && grid.spacing[axis] > 0.0);
  }
  return grid;
}

inline std::vector<Index> ascending_cells(const Grid& grid, const CArray<Index>& cells) {
  require(cells.ndim() == 1);
  const Index *first = cells.data(), *last = first + cells.size();
  require(std::adjacent_find(first, last, [](Index a, Index b) { return a >= b; }) == last);
  require(first == last || (*first >= 0 && last[-1] < grid.size()));
  return {first, last};
}

}  // namespace leadthrough
