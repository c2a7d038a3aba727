#include <pybind11/eigen.h>

#include "leadthrough/so3.hpp"
#include "parts.hpp"

namespace py = pybind11;

namespace leadthrough {

void bind_so3(py::module_& module) {
  using ReleaseGil = py::call_guard<py::gil_scoped_release>;

  module.def("so3_exp", &so3::exp_batch, py::arg("rotation_vectors").noconvert(), ReleaseGil());
  module.def("so3_log", &so3::log_batch, py::arg("quaternions").noconvert(), ReleaseGil());
  module.def("so3_compose", &so3::compose_batch, py::arg("a").noconvert(), py::arg("b").noconvert(),
             ReleaseGil());
  module.def("so3_to_matrix", &so3::to_matrix_batch, py::arg("quaternions").noconvert(),
             ReleaseGil());
  module.def("so3_distance", &so3::distance_batch, py::arg("a").noconvert(),
             py::arg("b").noconvert(), ReleaseGil());
}

}  // namespace leadthrough
