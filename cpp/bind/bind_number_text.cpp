#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "bind/parts.hpp"
#include "leadthrough/base/number_text.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

py::bytes write_records_(const Eigen::Ref<const Rows>& values, const RecordLayout& layout) {
  std::string text = without_gil([&] { return write_records(values, layout); });
  return py::bytes(text);
}

py::tuple read_records_(const py::bytes& block, const RecordLayout& layout) {
  const std::string_view text(block);
  Records found = without_gil([&] { return read_records(text, layout); });
  return py::make_tuple(moved_array(std::move(found.values)), found.length);
}

}  // namespace

void bind_number_text(py::module_& module) {
  py::class_<RecordLayout>(module, "RecordLayout")
      .def(py::init([](const std::vector<std::string>& texts,
                       const std::vector<Eigen::Index>& counts, const std::string& separator,
                       Eigen::Index integers) {
             require(std::all_of(counts.begin(), counts.end(), [](Eigen::Index count) {
               return count >= 0 && count < 1'000'000;
             }));
             return RecordLayout{texts, counts, separator, integers};
           }),
           py::arg("texts"), py::arg("counts"), py::arg("separator"), py::arg("integers") = 0);
  module.def("write_records", &write_records_, py::arg("values").noconvert(), py::arg("layout"));
  module.def("read_records", &read_records_, py::arg("block"), py::arg("layout"));
}

}  // namespace leadthrough
