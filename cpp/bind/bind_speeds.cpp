#include <pybind11/stl.h>

#include <memory>
#include <utility>
#include <vector>

#include "bind/grids.hpp"
#include "leadthrough/field/hindered_speeds.hpp"
#include "leadthrough/field/quickest.hpp"
#include "leadthrough/field/speed_map.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

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
  std::shared_ptr<const FreeSpeeds> map;
  {
    const Unlocked unlocked;
    map = std::make_shared<ExperienceSpeeds>(cells, saturation, points, radius);
  }
  return {cells, std::move(map)};
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
  std::shared_ptr<const SpeedMap> map;
  {
    const Unlocked unlocked;
    map = std::make_shared<PassableSpeeds>(free.free, walls.walls, band, reach);
  }
  return {free.cells, std::move(map)};
}

py::array_t<double> speeds_at(const BoundSpeeds& bound, const CArray<Index>& cells) {
  std::vector<double> found;
  {
    const UnlockedIf unlocked(cells.size() >= kManyCells);
    found = bound.map->at(ascending_cells(bound.cells.grid, cells));
  }
  return moved_array(std::move(found));
}

py::array_t<double> fastest_in(const BoundSpeeds& bound, int level, const CArray<Index>& numbers) {
  require(level >= 0 && level < 32);
  const Blocks blocks = blocks_of(bound.cells, level);
  std::vector<double> found;
  {
    const UnlockedIf unlocked(numbers.size() >= kManyCells);
    found = bound.map->fastest(blocks, ascending_cells(blocks.grid, numbers));
  }
  return moved_array(std::move(found));
}

const char* name(QuickestStatus status) {
  switch (status) {
    case QuickestStatus::kFound:
      return "found";
    case QuickestStatus::kStartInWall:
      return "start_in_wall";
    case QuickestStatus::kGoalInWall:
      return "goal_in_wall";
    case QuickestStatus::kSeparated:
      return "separated";
  }
  return "";
}

py::tuple quickest(const BoundSpeeds& bound, const std::vector<double>& start,
                   const std::vector<double>& goal) {
  const Point from = bound.cells.point(start), to = bound.cells.point(goal);
  const bool holds_start = bound.cells.find(from).has_value();
  const bool holds_goal = bound.cells.find(to).has_value();
  require((holds_start || holds_goal) &&
          ((holds_start && holds_goal) || bound.map->outside() > 0.0));
  Quickest found = without_gil([&] { return quickest_path(*bound.map, from, to); });
  return py::make_tuple(name(found.status), bound.cells.rows(found.path));
}

}  // namespace

void bind_speeds(py::module_& module) {
  py::class_<BoundSpeeds>(module, "SpeedMap")
      .def("at", &speeds_at, py::arg("cells").noconvert())
      .def("fastest", &fastest_in, py::arg("level"), py::arg("blocks").noconvert())
      .def("quickest", &quickest, py::arg("start"), py::arg("goal"));
  py::class_<BoundFree, BoundSpeeds>(module, "FreeSpeedMap");
  module.def("given_speeds", &given, py::arg("cells"), py::arg("outside"),
             py::arg("speeds").noconvert());
  module.def("experience_speeds", &experience, py::arg("cells"), py::arg("saturation"),
             py::arg("paths"), py::arg("radius"));
  module.def("tube_speeds", &about_tubes, py::arg("cells"), py::arg("saturation"), py::arg("paths"),
             py::arg("weights"), py::arg("radius"));
  module.def("hindered_speeds", &hindered, py::arg("free"), py::arg("walls"), py::arg("reach"));
  module.def("saturated_speeds", &saturated, py::arg("free"), py::arg("walls"), py::arg("reach"),
             py::arg("saturation"));
  module.def("passable_speeds", &passable, py::arg("free"), py::arg("walls"), py::arg("band"),
             py::arg("reach"));
}

}  // namespace leadthrough
