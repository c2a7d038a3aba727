#include <pybind11/eigen.h>

#include <algorithm>
#include <utility>

#include "bind/cells.hpp"
#include "leadthrough/learn/alignment.hpp"
#include "leadthrough/learn/arc_length.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

Polyline polyline_of(const CArray<double>& points) {
  require(points.ndim() == 2 && points.size() > 0);
  return {points.data(), static_cast<std::size_t>(points.shape(0)),
          static_cast<std::size_t>(points.shape(1))};
}

py::array_t<double> lengths_along(const CArray<double>& points) {
  const Polyline curve = polyline_of(points);
  std::vector<double> lengths;
  {
    const UnlockedIf unlocked(points.size() >= kLong);
    lengths = arc_lengths(curve);
  }
  return moved_array(std::move(lengths));
}

// Rows at even lengths; None where the length of the curve is not finite.
py::object resampled(const CArray<double>& points, std::size_t count) {
  const Polyline curve = polyline_of(points);
  require(count >= 2);
  std::vector<double> rows;
  {
    const UnlockedIf unlocked(std::max(points.size(), static_cast<py::ssize_t>(count)) >= kLong);
    const std::vector<double> lengths = arc_lengths(curve);
    if (std::isfinite(lengths.back())) rows = by_arc_length(curve, lengths, count);
  }
  if (rows.empty()) return py::none();
  return moved_array(std::move(rows), {static_cast<py::ssize_t>(count), points.shape(1)});
}

// A row and a column for each of the curves (k, n, d).
py::array_t<double> between_curves(const CArray<double>& curves) {
  require(curves.ndim() == 3 && curves.size() > 0);
  const auto count = static_cast<std::size_t>(curves.shape(0));
  const Polyline first{curves.data(), static_cast<std::size_t>(curves.shape(1)),
                       static_cast<std::size_t>(curves.shape(2))};
  std::vector<double> apart;
  {
    const UnlockedIf unlocked(curves.size() * curves.shape(0) >= kLong);
    apart = rms_apart(first, count);
  }
  return moved_array(std::move(apart), {curves.shape(0), curves.shape(0)});
}

}  // namespace

void bind_alignment(py::module_& module) {
  for (const auto& [name, compare] :
       {std::pair("dtw_distance", &dtw_distance), std::pair("frechet_distance", &frechet_distance)})
    module.def(name, compare, py::arg("a").noconvert(), py::arg("b").noconvert(), py::arg("band"),
               Unlocking());
  module.def("dtw_path", &dtw_path, py::arg("a").noconvert(), py::arg("b").noconvert(),
             Unlocking());
  module.def("arc_lengths", &lengths_along, py::arg("points").noconvert());
  module.def("rms_apart", &between_curves, py::arg("curves").noconvert());
  module.def("by_arc_length", &resampled, py::arg("points").noconvert(), py::arg("count"));
}

}  // namespace leadthrough
