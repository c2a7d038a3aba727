#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <vector>

#include "bind/grids.hpp"
#include "leadthrough/base/matrix.hpp"
#include "leadthrough/collision/shapes.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

// Of a flat grid, whose first axis is one cell, z is that axis: its cells lie in the plane z = 0.
Point along_axes(bool is_flat, const Eigen::Vector3d& p) {
  return is_flat ? Point{p.z(), p.x(), p.y()} : Point{p.x(), p.y(), p.z()};
}

Eigen::Vector3d in_space(bool is_flat, const Point& p) {
  return is_flat ? Eigen::Vector3d(p[1], p[2], p[0]) : Eigen::Vector3d(p[0], p[1], p[2]);
}

BoundWalls walls_of(const BoundGrid& cells, double margin, const std::vector<Shape>& shapes,
                    const Eigen::Ref<const Rows3>& middles,
                    const Eigen::Ref<const Rows3>& half_extents) {
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

}  // namespace

void bind_walls(py::module_& module) {
  py::class_<BoundGrid>(module, "Cells")
      .def(py::init<const std::vector<Index>&, const std::vector<double>&,
                    const std::vector<double>&>(),
           py::arg("shape"), py::arg("spacing"), py::arg("first"));
  py::class_<BoundWalls>(module, "Walls")
      .def(py::init(&walls_of), py::arg("cells"), py::arg("margin"), py::arg("shapes"),
           py::arg("middles").noconvert(), py::arg("half_extents").noconvert())
      .def("distances", &BoundWalls::distances, py::arg("cells").noconvert(), py::arg("most"));
}

}  // namespace leadthrough
