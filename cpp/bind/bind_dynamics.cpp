#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "leadthrough/arm/dynamics.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using RowsRef = Eigen::Ref<const Rows>;

Rows inverse_dynamics(const Dynamics& dynamics, const RowsRef& q, const RowsRef& qd,
                      const RowsRef& qdd, const Eigen::Vector3d& gravity) {
  require(q.cols() == dynamics.joints());
  for (const RowsRef* rates : {&qd, &qdd})
    require(rates->rows() == q.rows() && rates->cols() == q.cols());
  const Unlocked unlocked;
  return dynamics.torques(q, qd, qdd, gravity);
}

Rows mass_matrix(const Dynamics& dynamics, const RowsRef& q) {
  require(q.cols() == dynamics.joints());
  const Unlocked unlocked;
  return dynamics.mass_matrices(q);
}

}  // namespace

void bind_dynamics(py::module_& module) {
  py::class_<Dynamics>(module, "Dynamics")
      .def(py::init<const Chain&>(), py::arg("chain"))
      .def("inverse_dynamics", &inverse_dynamics, py::arg("q").noconvert(),
           py::arg("qd").noconvert(), py::arg("qdd").noconvert(), py::arg("gravity"))
      .def("mass_matrix", &mass_matrix, py::arg("q").noconvert());
}

}  // namespace leadthrough
