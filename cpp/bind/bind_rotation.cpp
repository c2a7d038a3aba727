#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "leadthrough/rotation/curve.hpp"
#include "leadthrough/rotation/mean.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

py::tuple mean(const Rows4Ref& layers, const VectorRef& weights) {
  so3::Means result = without_gil([&] { return so3::mean_batch(layers, weights); });
  return py::make_tuple(std::move(result.means), std::move(result.reach));
}

py::tuple lift(const Rows4Ref& quaternions) {
  so3::Lifted result = without_gil([&] { return so3::lift(quaternions); });
  return py::make_tuple(std::move(result.vectors), result.broken);
}

}  // namespace

void bind_rotation(py::module_& module) {
  module.def("so3_exp", &so3::exp_batch, "rotation_vectors"_array, Unlocking());
  module.def("so3_log", &so3::log_batch, "quaternions"_array, Unlocking());
  module.def("so3_compose", &so3::compose_batch, "a"_array, "b"_array, Unlocking());
  module.def("so3_to_matrix", &so3::to_matrix_batch, "quaternions"_array, Unlocking());
  module.def("so3_from_matrix", &so3::from_matrix_batch, "matrices"_array, Unlocking());
  module.def("so3_distance", &so3::distance_batch, "a"_array, "b"_array, Unlocking());
  module.def("so3_slerp", &so3::slerp_batch, "a"_array, "b"_array, "fractions"_array, Unlocking());
  module.def("so3_slerp_through", &so3::slerp_through, "times"_array, "quaternions"_array,
             "at"_array, Unlocking());
  module.def("so3_mean", &mean, "layers"_array, "weights"_array);
  module.def("so3_lift", &lift, "quaternions"_array);
  module.def("so3_left_jacobian", &so3::left_jacobian_batch, "rotation_vectors"_array, Unlocking());
  module.def("so3_left_jacobian_inverse", &so3::left_jacobian_inverse_batch,
             "rotation_vectors"_array, Unlocking());
  module.def("so3_integrate", &so3::integrate, "times"_array, "angular_velocities"_array,
             "start"_array, Unlocking());
}

}  // namespace leadthrough
