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

so3::Quaternions compose(const QuaternionsRef& a, const QuaternionsRef& b) {
  require(a.rows() == b.rows());
  const Unlocked unlocked;
  return so3::compose_batch(a, b);
}

Eigen::VectorXd distance(const QuaternionsRef& a, const QuaternionsRef& b) {
  require(a.rows() == b.rows());
  const Unlocked unlocked;
  return so3::distance_batch(a, b);
}

so3::Quaternions slerp(const QuaternionsRef& a, const QuaternionsRef& b,
                       const NumbersRef& fractions) {
  require(a.rows() == b.rows() && fractions.size() == a.rows());
  const Unlocked unlocked;
  return so3::slerp_batch(a, b, fractions);
}

so3::Quaternions slerp_through(const NumbersRef& times, const QuaternionsRef& quaternions,
                               const NumbersRef& at) {
  require(times.size() == quaternions.rows() && times.size() > 1);
  const Unlocked unlocked;
  return so3::slerp_through(times, quaternions, at);
}

so3::Quaternions integrate(const NumbersRef& times,
                           const Eigen::Ref<const so3::Vectors>& angular_velocities,
                           const Eigen::Ref<const so3::Quaternion>& start) {
  require(times.size() == angular_velocities.rows());
  const Unlocked unlocked;
  return so3::integrate(times, angular_velocities, start);
}

py::tuple mean(const QuaternionsRef& layers, const NumbersRef& weights) {
  require(weights.size() > 0 && layers.rows() % weights.size() == 0);
  so3::Means result;
  {
    const Unlocked unlocked;
    result = so3::mean_batch(layers, weights);
  }
  return py::make_tuple(std::move(result.means), std::move(result.reach));
}

py::tuple lift(const QuaternionsRef& quaternions) {
  so3::Lifted result;
  {
    const Unlocked unlocked;
    result = so3::lift(quaternions);
  }
  return py::make_tuple(std::move(result.vectors), result.broken);
}

}  // namespace

void bind_so3(py::module_& module) {
  using Unlocking = py::call_guard<Unlocked>;

  module.def("so3_exp", &so3::exp_batch, py::arg("rotation_vectors").noconvert(), Unlocking());
  module.def("so3_log", &so3::log_batch, py::arg("quaternions").noconvert(), Unlocking());
  module.def("so3_compose", &compose, py::arg("a").noconvert(), py::arg("b").noconvert());
  module.def("so3_to_matrix", &so3::to_matrix_batch, py::arg("quaternions").noconvert(),
             Unlocking());
  module.def("so3_from_matrix", &so3::from_matrix_batch, py::arg("matrices").noconvert(),
             Unlocking());
  module.def("so3_distance", &distance, py::arg("a").noconvert(), py::arg("b").noconvert());
  module.def("so3_slerp", &slerp, py::arg("a").noconvert(), py::arg("b").noconvert(),
             py::arg("fractions").noconvert());
  module.def("so3_slerp_through", &slerp_through, py::arg("times").noconvert(),
             py::arg("quaternions").noconvert(), py::arg("at").noconvert());
  module.def("so3_mean", &mean, py::arg("layers").noconvert(), py::arg("weights").noconvert());
  module.def("so3_lift", &lift, py::arg("quaternions").noconvert());
  module.def("so3_left_jacobian", &so3::left_jacobian_batch,
             py::arg("rotation_vectors").noconvert(), Unlocking());
  module.def("so3_left_jacobian_inverse", &so3::left_jacobian_inverse_batch,
             py::arg("rotation_vectors").noconvert(), Unlocking());
  module.def("so3_integrate", &integrate, py::arg("times").noconvert(),
             py::arg("angular_velocities").noconvert(), py::arg("start").noconvert());
}

}  // namespace leadthrough
