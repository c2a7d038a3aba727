#include <pybind11/numpy.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "bind/parts.hpp"
#include "leadthrough/base/finite.hpp"

namespace py = pybind11;

namespace leadthrough {

void bind_finite(py::module_& module) {
  // It keeps the GIL for most arrays: to let it go takes longer than they do.
  module.def(
      "all_finite",
      [](const py::array_t<double, py::array::c_style>& values) {
        std::optional<Unlocked> unlocked;
        if (values.size() >= kLong) unlocked.emplace();
        return all_finite(values.data(), static_cast<std::size_t>(values.size()));
      },
      py::arg("values").noconvert());
  // The quick ways of the checks: false and None for all that needs the slow ones.
  module.def(
      "is_finite_vector",
      [](const py::handle& value, const py::handle& size) {
        return PyLong_Check(size.ptr()) && finite_vector(value, PyLong_AsSsize_t(size.ptr()));
      },
      py::arg("value"), py::arg("size"));
  module.def(
      "unit_quaternion",
      [](const py::handle& value, double tolerance) -> py::object {
        const double* q = finite_vector(value, 4);
        if (!q) return py::none();
        const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        if (!(std::abs(length - 1.0) <= tolerance)) return py::none();
        const std::array<double, 4> unit{q[0] / length, q[1] / length, q[2] / length,
                                         q[3] / length};
        return py::array_t<double>(4, unit.data());
      },
      py::arg("value"), py::arg("tolerance"));
}

}  // namespace leadthrough
