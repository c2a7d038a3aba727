#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "leadthrough/arm/dynamics.hpp"

namespace py = pybind11;

namespace leadthrough {

void bind_dynamics(py::module_& module) {
  py::class_<Dynamics>(module, "Dynamics")
      .def(py::init<const Chain&>(), py::arg("chain"))
      .def("inverse_dynamics", &Dynamics::torques, py::arg("q").noconvert(),
           py::arg("qd").noconvert(), py::arg("qdd").noconvert(), py::arg("gravity"), Unlocking())
      .def("mass_matrix", &Dynamics::mass_matrices, py::arg("q").noconvert(), Unlocking());
}

}  // namespace leadthrough
