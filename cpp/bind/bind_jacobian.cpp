#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "leadthrough/arm/jacobian.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using RowsRef = Eigen::Ref<const Rows>;

bool fit(const Chain& chain, const RowsRef& q, const RowsRef& other) {
  return other.cols() == chain.joints() && other.rows() == q.rows();
}

}  // namespace

void bind_jacobian(py::module_& module) {
  module.def(
      "jacobian",
      [](const Chain& chain, const RowsRef& q) {
        require(fit(chain, q, q));
        const Unlocked unlocked;
        return jacobian_batch(chain, q);
      },
      py::arg("chain"), py::arg("q").noconvert());
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
  module.def(
      "jacobian_derivative",
      [](const Chain& chain, const RowsRef& q, const RowsRef& qd) {
        require(fit(chain, q, q) && fit(chain, q, qd));
        const Unlocked unlocked;
        return jacobian_derivative_batch(chain, q, qd);
      },
      py::arg("chain"), py::arg("q").noconvert(), py::arg("qd").noconvert());
  module.def(
      "jacobian_second_derivative",
      [](const Chain& chain, const RowsRef& q, const RowsRef& qd, const RowsRef& qdd) {
        require(fit(chain, q, q) && fit(chain, q, qd) && fit(chain, q, qdd));
        const Unlocked unlocked;
        return jacobian_second_derivative_batch(chain, q, qd, qdd);
      },
      py::arg("chain"), py::arg("q").noconvert(), py::arg("qd").noconvert(),
      py::arg("qdd").noconvert());
}

}  // namespace leadthrough
