#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "leadthrough/arm/dynamics.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using RowsRef = Eigen::Ref<const Rows>;

Rows inverse_dynamics(const Chain& chain, const RowsRef& q, const RowsRef& qd, const RowsRef& qdd,
                      const Eigen::Vector3d& gravity) {
  require(q.cols() == chain.joints());
  for (const RowsRef* rates : {&qd, &qdd})
    require(rates->rows() == q.rows() && rates->cols() == q.cols());
  const Unlocked unlocked;
  return inverse_dynamics_batch(chain, q, qd, qdd, gravity);
}

Rows mass_matrix(const Chain& chain, const RowsRef& q) {
  require(q.cols() == chain.joints());
  const Unlocked unlocked;
  return mass_matrix_batch(chain, q);
}

}  // namespace

void bind_dynamics(py::module_& module) {
  module.def("inverse_dynamics", &inverse_dynamics, py::arg("chain"), py::arg("q").noconvert(),
             py::arg("qd").noconvert(), py::arg("qdd").noconvert(), py::arg("gravity"));
  module.def("mass_matrix", &mass_matrix, py::arg("chain"), py::arg("q").noconvert());
}

}  // namespace leadthrough
