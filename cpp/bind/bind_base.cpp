#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "bind/parts.hpp"
#include "leadthrough/base/finite.hpp"
#include "leadthrough/base/number_text.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

py::bytes write_records_(const RowsRef& values, const RecordLayout& layout) {
  return py::bytes(without_gil([&] { return write_records(values, layout); }));
}

py::tuple read_records_(const py::bytes& block, const RecordLayout& layout) {
  const std::string_view text(block);
  Records found = without_gil([&] { return read_records(text, layout); });
  return py::make_tuple(moved_array(std::move(found.values)), found.length);
}

}  // namespace

void bind_base(py::module_& module) {
  // It keeps the GIL for most arrays: to let it go takes longer than they do.
  module.def(
      "all_finite",
      [](const CArray<double>& values) {
        return without_gil(
            [&] { return all_finite(values.data(), static_cast<std::size_t>(values.size())); },
            values.size() >= kLong);
      },
      "values"_array);
  // The quick ways of the checks: false and None for all that needs the slow ones.
  module.def(
      "is_finite_vector",
      [](const py::handle& value, const py::handle& size) {
        return PyLong_Check(size.ptr()) && finite_vector(value, PyLong_AsSsize_t(size.ptr()));
      },
      "value"_a, "size"_a);
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
      "value"_a, "tolerance"_a);

  py::class_<RecordLayout>(module, "RecordLayout")
      .def(py::init([](const std::vector<std::string>& texts,
                       const std::vector<Eigen::Index>& counts, const std::string& separator,
                       Eigen::Index integers) {
             require(std::all_of(counts.begin(), counts.end(), [](Eigen::Index count) {
               return count >= 0 && count < 1'000'000;
             }));
             return RecordLayout{texts, counts, separator, integers};
           }),
           "texts"_a, "counts"_a, "separator"_a, "integers"_a = 0);
  module.def("write_records", &write_records_, "values"_array, "layout"_a);
  module.def("read_records", &read_records_, "block"_a, "layout"_a);
}

}  // namespace leadthrough
