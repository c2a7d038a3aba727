#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "leadthrough/rotation/curve.hpp"
#include "leadthrough/rotation/mean.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using QuaternionsRef = Eigen::Ref<const so3::Quaternions>;
using NumbersRef = Eigen::Ref<const Eigen::VectorXd>;

py::tuple mean(const QuaternionsRef& layers, const NumbersRef& weights) {
  so3::Means result = without_gil([&] { return so3::mean_batch(layers, weights); });
  return py::make_tuple(std::move(result.means), std::move(result.reach));
}

py::tuple lift(const QuaternionsRef& quaternions) {
  so3::Lifted result = without_gil([&] { return so3::lift(quaternions); });
  return py::make_tuple(std::move(result.vectors), result.broken);
}

}  // namespace

void bind_so3(py::module_& module) {
  module.def("so3_exp", &so3::exp_batch, py::arg("rotation_vectors").noconvert(), Unlocking());
  module.def("so3_log", &so3::log_batch, py::arg("quaternions").noconvert(), Unlocking());
  module.def("so3_compose", &so3::compose_batch, py::arg("a").noconvert(), py::arg("b").noconvert(),
             Unlocking());
  module.def("so3_to_matrix", &so3::to_matrix_batch, py::arg("quaternions").noconvert(),
             Unlocking());
  module.def("so3_from_matrix", &so3::from_matrix_batch, py::arg("matrices").noconvert(),
             Unlocking());
  module.def("so3_distance", &so3::distance_batch, py::arg("a").noconvert(),
             py::arg("b").noconvert(), Unlocking());
  module.def("so3_slerp", &so3::slerp_batch, py::arg("a").noconvert(), py::arg("b").noconvert(),
             py::arg("fractions").noconvert(), Unlocking());
  module.def("so3_slerp_through", &so3::slerp_through, py::arg("times").noconvert(),
             py::arg("quaternions").noconvert(), py::arg("at").noconvert(), Unlocking());
  module.def("so3_mean", &mean, py::arg("layers").noconvert(), py::arg("weights").noconvert());
  module.def("so3_lift", &lift, py::arg("quaternions").noconvert());
  module.def("so3_left_jacobian", &so3::left_jacobian_batch,
             py::arg("rotation_vectors").noconvert(), Unlocking());
  module.def("so3_left_jacobian_inverse", &so3::left_jacobian_inverse_batch,
             py::arg("rotation_vectors").noconvert(), Unlocking());
  module.def("so3_integrate", &so3::integrate, py::arg("times").noconvert(),
             py::arg("angular_velocities").noconvert(), py::arg("start").noconvert(), Unlocking());
}

}  // namespace leadthrough
