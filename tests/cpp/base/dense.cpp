#include "base/dense.hpp"

#include <Eigen/SVD>

namespace leadthrough::test {

namespace {

Eigen::JacobiSVD<Eigen::MatrixXd> decompose(const Eigen::MatrixXd& matrix) {
  return Eigen::JacobiSVD<Eigen::MatrixXd>(matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
}

}  // namespace

Eigen::VectorXd singular_values(const Eigen::MatrixXd& matrix) {
  return decompose(matrix).singularValues();
}

Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& matrix) {
  const auto svd = decompose(matrix);
  const Eigen::Index rank = svd.rank();
  const Eigen::VectorXd inverted = svd.singularValues().head(rank).cwiseInverse();
  return svd.matrixV().leftCols(rank) * inverted.asDiagonal() *
         svd.matrixU().leftCols(rank).transpose();
}

}  // namespace leadthrough::test
