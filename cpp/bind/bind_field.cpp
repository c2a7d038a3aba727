#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <string>
#include <utility>

#include "leadthrough/descent.hpp"
#include "leadthrough/distance.hpp"
#include "leadthrough/eikonal.hpp"
#include "parts.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

template <typename T>
using CArray = py::array_t<T, py::array::c_style>;

// Arrays have 2 or 3 axes and `spacing` as many numbers; a 2D grid gets a first axis of one cell.
Grid grid_of(const py::array& cells, const std::vector<double>& spacing) {
  Grid grid;
  const std::size_t lead = 3 - spacing.size();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t given = axis < lead ? 0 : axis - lead;
    grid.shape[axis] = axis < lead ? 1 : cells.shape(static_cast<py::ssize_t>(given));
    grid.spacing[axis] = spacing[given];
  }
  return grid;
}

Coordinates with_leading_zero(const std::vector<double>& coordinates) {
  Coordinates result{};
  std::copy_backward(coordinates.begin(), coordinates.end(), result.end());
  return result;
}

// A numpy array that takes the vector over.
template <typename T>
py::array_t<T> owning(std::vector<T> values, std::vector<py::ssize_t> shape) {
  auto* kept = new std::vector<T>(std::move(values));
  const py::capsule owner(kept, [](void* data) { delete static_cast<std::vector<T>*>(data); });
  return py::array_t<T>(std::move(shape), kept->data(), owner);
}

std::vector<py::ssize_t> shape_of(const py::array& array) {
  return {array.shape(), array.shape() + array.ndim()};
}

template <typename Real>
py::array_t<Real> march(const CArray<Real>& speed, const std::vector<double>& spacing,
                        const CArray<Index>& cells, const CArray<double>& times, int order,
                        Index stop) {
  const Grid grid = grid_of(speed, spacing);
  std::vector<Source> sources;
  for (py::ssize_t n = 0; n < cells.size(); ++n) sources.push_back({cells.at(n), times.at(n)});
  std::vector<Real> arrival;
  {
    const py::gil_scoped_release release;
    arrival = order == 1 ? march_first_order(grid, speed.data(), sources, stop)
                         : march_second_order(grid, speed.data(), sources, stop);
  }
  return owning(std::move(arrival), shape_of(speed));
}

py::array_t<double> transform(const CArray<bool>& mask, const std::vector<double>& spacing) {
  const Grid grid = grid_of(mask, spacing);
  std::vector<double> distance;
  {
    const py::gil_scoped_release release;
    distance = distance_transform(grid, reinterpret_cast<const std::uint8_t*>(mask.data()));
  }
  return owning(std::move(distance), shape_of(mask));
}

const char* name(DescentStatus status) {
  switch (status) {
    case DescentStatus::kOk:
      return "ok";
    case DescentStatus::kStartOutside:
      return "start_outside";
    case DescentStatus::kStartUnreached:
      return "start_unreached";
    case DescentStatus::kGoalNotSource:
      return "goal_not_source";
    case DescentStatus::kOtherSource:
      return "other_source";
    case DescentStatus::kTooManySteps:
      break;
  }
  return "too_many_steps";
}

py::tuple follow_down(const CArray<double>& arrival, const std::vector<double>& spacing,
                      const std::vector<double>& start, const std::vector<double>& goal,
                      double step) {
  const Grid grid = grid_of(arrival, spacing);
  Descent descent;
  {
    const py::gil_scoped_release release;
    descent =
        descend(grid, arrival.data(), with_leading_zero(start), with_leading_zero(goal), step);
  }
  const std::size_t dimensions = spacing.size();
  py::array_t<double> path({descent.path.size(), dimensions});
  double* to = path.mutable_data();
  for (const Coordinates& p : descent.path)
    to = std::copy(p.end() - static_cast<std::ptrdiff_t>(dimensions), p.end(), to);
  return py::make_tuple(name(descent.status), path);
}

}  // namespace

void bind_field(py::module_& module) {
  module.def("march_float32", &march<float>, py::arg("speed").noconvert(), py::arg("spacing"),
             py::arg("cells").noconvert(), py::arg("times").noconvert(), py::arg("order"),
             py::arg("stop"));
  module.def("march_float64", &march<double>, py::arg("speed").noconvert(), py::arg("spacing"),
             py::arg("cells").noconvert(), py::arg("times").noconvert(), py::arg("order"),
             py::arg("stop"));
  module.def("distance_transform", &transform, py::arg("mask").noconvert(), py::arg("spacing"));
  module.def("descend", &follow_down, py::arg("arrival").noconvert(), py::arg("spacing"),
             py::arg("start"), py::arg("goal"), py::arg("step"));
}

}  // namespace leadthrough
