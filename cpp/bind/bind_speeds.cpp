#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "bind/cells.hpp"
#include "leadthrough/base/matrix.hpp"
#include "leadthrough/collision/shapes.hpp"
#include "leadthrough/field/blocks.hpp"
#include "leadthrough/field/hindered_speeds.hpp"
#include "leadthrough/field/quickest.hpp"
#include "leadthrough/field/speed_map.hpp"
#include "leadthrough/field/walls.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

// Maps over the cells of a grid as they come from Python.
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
    for (py::ssize_t i = 0; i < rows.shape(0); ++i)
      for (py::ssize_t axis = 0; axis < dimensions; ++axis)
        result[i][3 - dimensions + axis] = rows(i, axis);
    return result;
  }

  // A row for each point, in as many dimensions as the grid has.
  py::array_t<double> rows(const std::vector<Point>& points) const {
    py::array_t<double> result({points.size(), static_cast<std::size_t>(dimensions)});
    double* to = result.mutable_data();
    for (const Point& each : points) to = std::copy(each.end() - dimensions, each.end(), to);
    return result;
  }
};

struct BoundWalls {
  BoundGrid cells;
  Walls walls;

  py::array_t<double> distances(const CArray<Index>& numbers, double most) const {
    require(std::isfinite(most) && most > 0.0);
    return moved_array(
        without_gil([&] { return walls.distances(ascending_cells(cells.grid, numbers), most); }));
  }
};

// Of a flat grid, whose first axis is one cell, z is that axis: its cells lie in the plane z = 0.
Point along_axes(bool is_flat, const Eigen::Vector3d& p) {
  return is_flat ? Point{p.z(), p.x(), p.y()} : Point{p.x(), p.y(), p.z()};
}

Eigen::Vector3d in_space(bool is_flat, const Point& p) {
  return is_flat ? Eigen::Vector3d(p[1], p[2], p[0]) : Eigen::Vector3d(p[0], p[1], p[2]);
}

BoundWalls walls_of(const BoundGrid& cells, double margin, const std::vector<Shape>& shapes,
                    const Rows3Ref& middles, const Rows3Ref& half_extents) {
  const auto count = static_cast<Eigen::Index>(shapes.size());
  require(margin >= 0.0 && middles.rows() == count && half_extents.rows() == count);
  const bool is_flat = cells.is_flat();
  std::vector<Obstacle> obstacles;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Shape& shape = shapes[static_cast<std::size_t>(i)];
    const auto distance = [shape, is_flat](const Point& p) {
      return distance_to(shape, in_space(is_flat, p));
    };
    obstacles.push_back(
        {distance, along_axes(is_flat, middles.row(i)), along_axes(is_flat, half_extents.row(i))});
  }
  return {cells, Walls(cells, margin, std::move(obstacles))};
}

using Paths = std::vector<CArray<double>>;

struct BoundSpeeds {
  BoundGrid cells;
  std::shared_ptr<const SpeedMap> map;
};

struct BoundFree : BoundSpeeds {
  BoundFree(const BoundGrid& grid, std::shared_ptr<const FreeSpeeds> speed_map)
      : BoundSpeeds{grid, speed_map}, free(std::move(speed_map)) {}

  std::shared_ptr<const FreeSpeeds> free;
};

std::vector<std::vector<Point>> paths_in(const BoundGrid& cells, const Paths& paths) {
  std::vector<std::vector<Point>> result;
  for (const auto& path : paths) result.push_back(cells.points(path));
  return result;
}

BoundSpeeds given(const BoundGrid& cells, double outside, const CArray<double>& speeds) {
  require(outside >= 0.0);
  std::vector<double> copies(speeds.data(), speeds.data() + speeds.size());
  return {cells, std::make_shared<GivenSpeeds>(cells, outside, std::move(copies))};
}

BoundFree experience(const BoundGrid& cells, double saturation, const Paths& paths, double radius) {
  require(radius > 0.0 && saturation > 0.0);
  const auto points = paths_in(cells, paths);
  return {cells, without_gil([&] {
            return std::make_shared<ExperienceSpeeds>(cells, saturation, points, radius);
          })};
}

BoundFree about_tubes(const BoundGrid& cells, double saturation, const Paths& paths,
                      const std::vector<double>& weights, double radius) {
  require(paths.size() == weights.size() && radius > 0.0 && saturation > 0.0);
  std::vector<Tube> tubes;
  for (std::size_t n = 0; n < paths.size(); ++n)
    tubes.push_back({cells.points(paths[n]), weights[n]});
  return {cells, std::make_shared<TubeSpeeds>(cells, saturation, std::move(tubes), radius)};
}

BoundSpeeds hindered(const BoundSpeeds& free, const BoundWalls& walls, double reach) {
  require(reach > 0.0 && free.cells.grid.shape == walls.cells.grid.shape);
  return {free.cells, std::make_shared<HinderedSpeeds>(free.map, walls.walls, reach)};
}

BoundSpeeds saturated(const BoundSpeeds& free, const BoundWalls& walls, double reach,
                      double saturation) {
  require(reach > 0.0 && free.cells.grid.shape == walls.cells.grid.shape);
  auto map = std::make_shared<SaturatedSpeeds>(free.map, walls.walls, reach, saturation);
  return {free.cells, std::move(map)};
}

BoundSpeeds passable(const BoundFree& free, const BoundWalls& walls, double band, double reach) {
  require(band > 0.0 && reach > 0.0 && free.cells.grid.shape == walls.cells.grid.shape);
  return {free.cells, without_gil([&] {
            return std::make_shared<PassableSpeeds>(free.free, walls.walls, band, reach);
          })};
}

py::array_t<double> speeds_at(const BoundSpeeds& bound, const CArray<Index>& cells) {
  return moved_array(
      without_gil([&] { return bound.map->at(ascending_cells(bound.cells.grid, cells)); },
                  cells.size() >= kManyCells));
}

py::array_t<double> fastest_in(const BoundSpeeds& bound, int level, const CArray<Index>& numbers) {
  require(level >= 0 && level < 32);
  const Blocks blocks = blocks_of(bound.cells, level);
  return moved_array(
      without_gil([&] { return bound.map->fastest(blocks, ascending_cells(blocks.grid, numbers)); },
                  numbers.size() >= kManyCells));
}

py::tuple quickest(const BoundSpeeds& bound, const std::vector<double>& start,
                   const std::vector<double>& goal) {
  const Point from = bound.cells.point(start), to = bound.cells.point(goal);
  const bool holds_start = bound.cells.find(from).has_value();
  const bool holds_goal = bound.cells.find(to).has_value();
  require((holds_start || holds_goal) &&
          ((holds_start && holds_goal) || bound.map->outside() > 0.0));
  Quickest found = without_gil([&] { return quickest_path(*bound.map, from, to); });
  // In the order of QuickestStatus.
  constexpr std::array names{"found", "start_in_wall", "goal_in_wall", "separated"};
  return py::make_tuple(names[static_cast<std::size_t>(found.status)],
                        bound.cells.rows(found.path));
}

}  // namespace

void bind_speeds(py::module_& module) {
  py::class_<BoundGrid>(module, "Cells")
      .def(py::init<const std::vector<Index>&, const std::vector<double>&,
                    const std::vector<double>&>(),
           "shape"_a, "spacing"_a, "first"_a);
  py::class_<BoundWalls>(module, "Walls")
      .def(py::init(&walls_of), "cells"_a, "margin"_a, "shapes"_a, "middles"_array,
           "half_extents"_array)
      .def("distances", &BoundWalls::distances, "cells"_array, "most"_a);

  py::class_<BoundSpeeds>(module, "SpeedMap")
      .def("at", &speeds_at, "cells"_array)
      .def("fastest", &fastest_in, "level"_a, "blocks"_array)
      .def("quickest", &quickest, "start"_a, "goal"_a);
  py::class_<BoundFree, BoundSpeeds>(module, "FreeSpeedMap");
  module.def("given_speeds", &given, "cells"_a, "outside"_a, "speeds"_array);
  module.def("experience_speeds", &experience, "cells"_a, "saturation"_a, "paths"_a, "radius"_a);
  module.def("tube_speeds", &about_tubes, "cells"_a, "saturation"_a, "paths"_a, "weights"_a,
             "radius"_a);
  module.def("hindered_speeds", &hindered, "free"_a, "walls"_a, "reach"_a);
  module.def("saturated_speeds", &saturated, "free"_a, "walls"_a, "reach"_a, "saturation"_a);
  module.def("passable_speeds", &passable, "free"_a, "walls"_a, "band"_a, "reach"_a);
}

}  // namespace leadthrough
