#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "learn/bells.hpp"
#include "learn/bouncing.hpp"
#include "learn/dense.hpp"
#include "learn/gaussian.hpp"

namespace py = pybind11;

namespace leadthrough {

void bind_gaussian(py::module_& module) {
  module.def(
      "bounced",
      [](const Eigen::Ref<const Rows>& walls, const Eigen::Ref<const Eigen::VectorXd>& limits,
         const Eigen::Ref<const Eigen::VectorXd>& start, const Eigen::Ref<const Rows>& velocities) {
        require(limits.size() == walls.rows() && start.size() == walls.cols() &&
                velocities.cols() == walls.cols() &&
                (walls.rowwise().squaredNorm().array() > 0.0).all());
        const py::gil_scoped_release release;
        return bounced(walls, limits, start, velocities);
      },
      py::arg("walls").noconvert(), py::arg("limits").noconvert(), py::arg("start").noconvert(),
      py::arg("velocities").noconvert());
  module.def(
      "condition_weights",
      [](const Eigen::Ref<const Eigen::VectorXd>& mean, const Eigen::Ref<const Rows>& covariance,
         const Eigen::Ref<const Rows>& basis, const Eigen::Ref<const Columns>& columns,
         const Eigen::Ref<const Rows>& values, const Eigen::Ref<const Rows>& noise,
         const Eigen::Ref<const Eigen::VectorXd>& scale, double least) {
        require(basis.cols() > 0 && mean.size() % basis.cols() == 0 &&
                covariance.rows() == mean.size() && covariance.cols() == mean.size() &&
                values.rows() == basis.rows() && values.cols() == columns.size() &&
                noise.rows() == columns.size() && noise.cols() == columns.size() &&
                scale.size() == columns.size() && (columns.array() >= 0).all() &&
                (columns.array() < mean.size() / basis.cols()).all());
        Conditioned result = [&] {
          const py::gil_scoped_release release;
          return condition_weights(mean, covariance, basis, columns, values, noise, scale, least);
        }();
        return py::make_tuple(result.certain, std::move(result.mean), std::move(result.covariance));
      },
      py::arg("mean").noconvert(), py::arg("covariance").noconvert(), py::arg("basis").noconvert(),
      py::arg("columns").noconvert(), py::arg("values").noconvert(), py::arg("noise").noconvert(),
      py::arg("scale").noconvert(), py::arg("least"));
  module.def(
      "product",
      [](const Eigen::Ref<const Rows>& left, const Eigen::Ref<const Rows>& right) {
        require(left.cols() == right.rows());
        const py::gil_scoped_release release;
        return product(left, right);
      },
      py::arg("left").noconvert(), py::arg("right").noconvert());
  module.def(
      "solve_definite",
      [](const Eigen::Ref<const Rows>& matrix, const Eigen::Ref<const Rows>& right) {
        require(matrix.rows() == matrix.cols() && matrix.rows() == right.rows());
        const py::gil_scoped_release release;
        return solve_definite(matrix, right);
      },
      py::arg("matrix").noconvert(), py::arg("right").noconvert());
  module.def(
      "is_covariance",
      [](const Eigen::Ref<const Rows>& matrix) {
        require(matrix.rows() == matrix.cols() && matrix.rows() > 0);
        const py::gil_scoped_release release;
        return is_covariance(matrix);
      },
      py::arg("matrix").noconvert());
  module.def(
      "normalised_bells",
      [](const Eigen::Ref<const Eigen::VectorXd>& phases,
         const Eigen::Ref<const Eigen::VectorXd>& centres, double sharpness, bool periodic,
         int order) {
        require(order >= 0 && order <= 2);
        const py::gil_scoped_release release;
        return normalised_bells(phases, centres, sharpness, periodic, order);
      },
      py::arg("phases").noconvert(), py::arg("centres").noconvert(), py::arg("sharpness"),
      py::arg("periodic"), py::arg("order"));
}

}  // namespace leadthrough
