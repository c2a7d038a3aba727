#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "time/curve_values.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using Vector = Eigen::Ref<const Eigen::VectorXd>;
using Table = Eigen::Ref<const Rows>;

Rows polynomial_values_(const Vector& knots, const Table& coefficients, const Vector& times,
                        int order) {
  require(knots.size() > 1 && coefficients.rows() > 0 && coefficients.cols() > 0 &&
          coefficients.rows() % (knots.size() - 1) == 0 && order >= 0);
  const py::gil_scoped_release release;
  return polynomial_values(knots, coefficients, times, order);
}

Rows bezier_values_(const Table& points, const Vector& fractions) {
  require(points.rows() > 0 && points.cols() > 0);
  const py::gil_scoped_release release;
  return bezier_values(points, fractions);
}

}  // namespace

void bind_curves(py::module_& module) {
  module.def("polynomial_values", &polynomial_values_, py::arg("knots").noconvert(),
             py::arg("coefficients").noconvert(), py::arg("times").noconvert(), py::arg("order"));
  module.def("bezier_values", &bezier_values_, py::arg("points").noconvert(),
             py::arg("fractions").noconvert());
}

}  // namespace leadthrough
