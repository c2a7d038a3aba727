#pragma once

// Maps over the cells of a grid as they come from Python.

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "bind/cells.hpp"
#include "leadthrough/field/blocks.hpp"
#include "leadthrough/field/walls.hpp"

namespace leadthrough {

struct BoundGrid : Blocks {
  BoundGrid(const std::vector<Index>& shape, const std::vector<double>& spacing,
            const std::vector<double>& centre)
      : Blocks{grid_of(shape, spacing), {}, static_cast<int>(shape.size())} {
    first = point(centre);
  }

  bool is_flat() const { return dimensions == 2; }

  Point point(const std::vector<double>& coordinates) const {
    require(coordinates.size() == static_cast<std::size_t>(dimensions));
    require(std::all_of(coordinates.begin(), coordinates.end(),
                        [](double each) { return std::isfinite(each); }));
    Point result{};
    std::copy_backward(coordinates.begin(), coordinates.end(), result.end());
    return result;
  }

  // The points of a path (n, d).
  std::vector<Point> points(const CArray<double>& path) const {
    const auto rows = path.unchecked<2>();
    require(rows.shape(0) > 0 && rows.shape(1) == dimensions);
    std::vector<Point> result(static_cast<std::size_t>(rows.shape(0)), Point{});
    for (pybind11::ssize_t i = 0; i < rows.shape(0); ++i)
      for (pybind11::ssize_t axis = 0; axis < dimensions; ++axis)
        result[i][3 - dimensions + axis] = rows(i, axis);
    return result;
  }

  // A row for each point, in as many dimensions as the grid has.
  pybind11::array_t<double> rows(const std::vector<Point>& points) const {
    pybind11::array_t<double> result({points.size(), static_cast<std::size_t>(dimensions)});
    double* to = result.mutable_data();
    for (const Point& each : points) to = std::copy(each.end() - dimensions, each.end(), to);
    return result;
  }
};

struct BoundWalls {
  BoundGrid cells;
  Walls walls;

  pybind11::array_t<double> distances(const CArray<Index>& numbers, double most) const {
    require(std::isfinite(most) && most > 0.0);
    std::vector<double> found;
    {
      const Unlocked unlocked;
      found = walls.distances(ascending_cells(cells.grid, numbers), most);
    }
    return moved_array(std::move(found));
  }
};

}  // namespace leadthrough
