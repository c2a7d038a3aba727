#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "leadthrough/arm/jacobian.hpp"

namespace py = pybind11;

namespace leadthrough {

void bind_jacobian(py::module_& module) {
  module.def("jacobian", &jacobian_batch, py::arg("chain"), py::arg("q").noconvert(), Unlocking());
  module.def(
      "jacobian_of_one",
      [](const Chain& chain, const py::object& q) -> py::object {
        const double* joints = finite_vector(q, chain.joints());
        if (!joints) return py::none();
        Kinematics kinematics;
        forward_kinematics(chain, joints, kinematics);
        py::array_t<double> matrix({6, chain.joints()});
        auto entries = matrix.mutable_unchecked<2>();
        bool finite = true;
        for (int column = 0; column < chain.joints(); ++column) {
          const Vector6& twist = kinematics.jacobian[static_cast<std::size_t>(column)];
          finite = finite && twist.allFinite();
          for (int row = 0; row < 6; ++row) entries(row, column) = twist[row];
        }
        return finite ? py::object(matrix) : py::none();
      },
      py::arg("chain"), py::arg("q"));
  module.def("jacobian_derivative", &jacobian_derivative_batch, py::arg("chain"),
             py::arg("q").noconvert(), py::arg("qd").noconvert(), Unlocking());
  module.def("jacobian_second_derivative", &jacobian_second_derivative_batch, py::arg("chain"),
             py::arg("q").noconvert(), py::arg("qd").noconvert(), py::arg("qdd").noconvert(),
             Unlocking());
}

}  // namespace leadthrough
