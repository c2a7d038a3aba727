#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "learn/alignment.hpp"

namespace py = pybind11;

namespace leadthrough {

void bind_alignment(py::module_& module) {
  using ReleaseGil = py::call_guard<py::gil_scoped_release>;

  module.def("dtw_distance", &dtw_distance, py::arg("a").noconvert(), py::arg("b").noconvert(),
             ReleaseGil());
  module.def("dtw_path", &dtw_path, py::arg("a").noconvert(), py::arg("b").noconvert(),
             ReleaseGil());
  module.def("frechet_distance", &frechet_distance, py::arg("a").noconvert(),
             py::arg("b").noconvert(), ReleaseGil());
}

}  // namespace leadthrough
