#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <utility>
#include <vector>

#include "base/matrix.hpp"
#include "bind/cells.hpp"
#include "collision/signed_distance.hpp"
#include "field/blocks.hpp"
#include "field/walls.hpp"

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

class BoundBlocks : public Blocks {
 public:
  BoundBlocks(const std::vector<Index>& shape, const std::vector<double>& spacing,
              const std::vector<double>& centre, double radius)
      : Blocks{grid_of(shape, spacing), {}, radius}, dimensions(shape.size()) {
    require(centre.size() == dimensions && radius >= 0.0);
    std::copy_backward(centre.begin(), centre.end(), first.end());
  }

  bool is_flat() const { return dimensions == 2; }

  std::vector<Index> checked(const CArray<Index>& numbers) const {
    require(numbers.ndim() == 1);
    const Index *begin = numbers.data(), *end = begin + numbers.size();
    require(std::all_of(begin, end, [&](Index n) { return n >= 0 && n < grid.size(); }));
    return {begin, end};
  }

  // A row for each block, in as many dimensions as the grid has.
  py::array_t<double> centres(const CArray<Index>& numbers) const {
    py::array_t<double> rows({numbers.size(), static_cast<py::ssize_t>(dimensions)});
    double* to = rows.mutable_data();
    const ReleaseIf release(numbers.size() >= kManyCells);
    for (const Index number : checked(numbers)) {
      const Point middle = centre(number);
      to = std::copy(middle.end() - static_cast<std::ptrdiff_t>(dimensions), middle.end(), to);
    }
    return rows;
  }

  std::size_t dimensions;
};

py::array_t<double> speeds_about(const BoundBlocks& blocks, const CArray<Index>& numbers,
                                 const std::vector<CArray<double>>& paths,
                                 const std::vector<double>& weights, double radius,
                                 double saturation) {
  require(paths.size() == weights.size() && radius > 0.0);
  std::vector<Tube> tubes;
  for (std::size_t n = 0; n < paths.size(); ++n) {
    const auto rows = paths[n].unchecked<2>();
    require(rows.shape(0) > 0 && static_cast<std::size_t>(rows.shape(1)) == blocks.dimensions);
    Tube tube{std::vector<Point>(static_cast<std::size_t>(rows.shape(0)), Point{}), weights[n]};
    const std::size_t lead = 3 - blocks.dimensions;
    for (py::ssize_t i = 0; i < rows.shape(0); ++i)
      for (py::ssize_t axis = 0; axis < rows.shape(1); ++axis)
        tube.path[i][lead + axis] = rows(i, axis);
    tubes.push_back(std::move(tube));
  }
  std::vector<double> speeds;
  {
    const ReleaseIf release(numbers.size() >= kManyCells);
    speeds = tube_speeds(blocks, blocks.checked(numbers), tubes, radius, saturation);
  }
  return moved_array(std::move(speeds));
}

class BoundWalls {
 public:
  BoundWalls(const BoundBlocks& cells, double margin, const std::vector<Shape>& shapes,
             const Eigen::Ref<const Rows3>& middles, const Eigen::Ref<const Rows3>& half_extents)
      : is_flat_(cells.is_flat()),
        cells_(cells),
        walls_(cells, margin, obstacles_of(shapes, middles, half_extents)) {
    require(margin >= 0.0);
  }

  py::array_t<bool> hold(const CArray<Index>& numbers) const {
    py::array_t<bool> result(numbers.size());
    bool* to = result.mutable_data();
    const ReleaseIf release(numbers.size() >= kManyCells);
    const std::vector<std::uint8_t> held = walls_.hold(cells_.checked(numbers));
    std::transform(held.begin(), held.end(), to, [](std::uint8_t each) { return each != 0; });
    return result;
  }

  py::array_t<double> distances(const CArray<Index>& numbers, double most) const {
    require(std::isfinite(most) && most > 0.0);
    std::vector<double> found;
    {
      const py::gil_scoped_release release;
      found = walls_.distances(ascending_cells(cells_.grid, numbers), most);
    }
    return moved_array(std::move(found));
  }

  py::array_t<double> farthest(const BoundBlocks& blocks, const CArray<Index>& numbers,
                               double most) const {
    return bounds(&Walls::farthest, blocks, numbers, most);
  }

  py::array_t<double> nearest(const BoundBlocks& blocks, const CArray<Index>& numbers,
                              double most) const {
    return bounds(&Walls::nearest, blocks, numbers, most);
  }

 private:
  using Bounds = std::vector<double> (Walls::*)(const Blocks&, const std::vector<Index>&,
                                                double) const;

  std::vector<Obstacle> obstacles_of(const std::vector<Shape>& shapes, const Rows3& middles,
                                     const Rows3& half_extents) const {
    const auto count = static_cast<Eigen::Index>(shapes.size());
    require(middles.rows() == count && half_extents.rows() == count);
    std::vector<Obstacle> obstacles;
    for (Eigen::Index i = 0; i < count; ++i) {
      const Shape& shape = shapes[static_cast<std::size_t>(i)];
      const auto distance = [shape, flat = is_flat_](const Point& p) {
        return distance_to(shape, in_space(flat, p));
      };
      obstacles.push_back({distance, along_axes(is_flat_, middles.row(i)),
                           along_axes(is_flat_, half_extents.row(i))});
    }
    return obstacles;
  }

  py::array_t<double> bounds(Bounds bound, const BoundBlocks& blocks, const CArray<Index>& numbers,
                             double most) const {
    require(std::isfinite(most) && most > 0.0 && blocks.is_flat() == is_flat_);
    std::vector<double> found;
    {
      const ReleaseIf release(numbers.size() >= kManyCells);
      found = (walls_.*bound)(blocks, blocks.checked(numbers), most);
    }
    return moved_array(std::move(found));
  }

  bool is_flat_;
  BoundBlocks cells_;
  Walls walls_;
};

}  // namespace

void bind_blocks(py::module_& module) {
  py::class_<BoundBlocks>(module, "Blocks")
      .def(py::init<const std::vector<Index>&, const std::vector<double>&,
                    const std::vector<double>&, double>(),
           py::arg("shape"), py::arg("spacing"), py::arg("first"), py::arg("reach"))
      .def("centres", &BoundBlocks::centres, py::arg("numbers").noconvert());
  module.def("tube_speeds", &speeds_about, py::arg("blocks"), py::arg("numbers").noconvert(),
             py::arg("paths"), py::arg("weights"), py::arg("radius"), py::arg("saturation"));
  py::class_<BoundWalls>(module, "Walls")
      .def(py::init<const BoundBlocks&, double, const std::vector<Shape>&,
                    const Eigen::Ref<const Rows3>&, const Eigen::Ref<const Rows3>&>(),
           py::arg("cells"), py::arg("margin"), py::arg("shapes"), py::arg("middles").noconvert(),
           py::arg("half_extents").noconvert())
      .def("hold", &BoundWalls::hold, py::arg("numbers").noconvert())
      .def("distances", &BoundWalls::distances, py::arg("numbers").noconvert(), py::arg("most"))
      .def("farthest", &BoundWalls::farthest, py::arg("blocks"), py::arg("numbers").noconvert(),
           py::arg("most"))
      .def("nearest", &BoundWalls::nearest, py::arg("blocks"), py::arg("numbers").noconvert(),
           py::arg("most"));
}

}  // namespace leadthrough
