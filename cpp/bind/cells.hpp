#pragma once

// Cells of grids as they come from Python, and arrays that go there without a copy.

#include <pybind11/numpy.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "bind/parts.hpp"
#include "field/cell_set.hpp"

namespace leadthrough {

template <typename T>
using CArray = pybind11::array_t<T, pybind11::array::c_style>;

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

// The vector's own memory as an array.
template <typename Value>
pybind11::array_t<Value> moved_array(std::vector<Value>&& values) {
  auto owner = std::make_unique<std::vector<Value>>(std::move(values));
  const pybind11::capsule memory(owner.get(),
                                 [](void* kept) { delete static_cast<std::vector<Value>*>(kept); });
  const std::vector<Value>& kept = *owner.release();
  return pybind11::array_t<Value>(static_cast<pybind11::ssize_t>(kept.size()), kept.data(), memory);
}

}  // namespace leadthrough
