#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "leadthrough/time/cubic_spline.hpp"
#include "leadthrough/time/curve_values.hpp"
#include "leadthrough/time/spline_fit.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using Vector = Eigen::Ref<const Eigen::VectorXd>;
using Table = Eigen::Ref<const Rows>;

py::tuple fit_spline_(const Vector& parameters, const Table& q, double tolerance, bool corners) {
  SplineFit fit = without_gil([&] { return fit_spline(parameters, q, tolerance, corners); });
  return py::make_tuple(as_array(fit.breaks), std::move(fit.coefficients));
}

py::tuple smooth_spline_(const Vector& parameters, const Table& q, double tolerance,
                         const Vector& lower, const Vector& upper) {
  SplineFit fit =
      without_gil([&] { return smooth_spline(parameters, q, tolerance, {lower, upper}); });
  return py::make_tuple(as_array(fit.breaks), std::move(fit.coefficients));
}

Rows spline_slopes_(const Vector& parameters, const Table& q, bool at_rest) {
  const Unlocked unlocked;
  return spline_slopes(parameters, q, at_rest ? SplineEnds::kAtRest : SplineEnds::kSmooth);
}

py::array_t<Eigen::Index> rows_apart_(const Table& q, double tolerance) {
  std::vector<Eigen::Index> rows = without_gil([&] { return rows_apart(q, tolerance); });
  return as_array(rows);
}

}  // namespace

void bind_spline_fit(py::module_& module) {
  module.def("fit_spline", &fit_spline_, py::arg("parameters").noconvert(),
             py::arg("q").noconvert(), py::arg("tolerance"), py::arg("corners"));
  module.def("smooth_spline", &smooth_spline_, py::arg("parameters").noconvert(),
             py::arg("q").noconvert(), py::arg("tolerance"), py::arg("lower").noconvert(),
             py::arg("upper").noconvert());
  module.def("cubic_through", &cubic_through, py::arg("parameters").noconvert(),
             py::arg("q").noconvert(), Unlocking());
  module.def("spline_slopes", &spline_slopes_, py::arg("parameters").noconvert(),
             py::arg("q").noconvert(), py::arg("at_rest"));
  module.def("polynomial_values", &polynomial_values, py::arg("knots").noconvert(),
             py::arg("coefficients").noconvert(), py::arg("times").noconvert(), py::arg("order"),
             Unlocking());
  module.def("bezier_values", &bezier_values, py::arg("points").noconvert(),
             py::arg("fractions").noconvert(), Unlocking());
  module.def("rows_apart", &rows_apart_, py::arg("q").noconvert(), py::arg("tolerance"));
}

}  // namespace leadthrough
