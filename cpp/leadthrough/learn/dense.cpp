#include "leadthrough/learn/dense.hpp"

#include <Eigen/Cholesky>

#include "leadthrough/base/argument.hpp"

namespace leadthrough {

Rows product(const RowsRef& left, const RowsRef& right) {
  check_argument(left.cols() == right.rows(), "right: expected as many rows as left has columns");
  return left * right;
}

Rows solve_definite(const RowsRef& matrix, const RowsRef& right) {
  check_argument(matrix.rows() == matrix.cols() && right.rows() == matrix.rows(),
                 "matrix, right: expected a square one and as many rows");
  const Eigen::LLT<Rows> root(matrix);
  if (root.info() != Eigen::Success) return {};
  return root.solve(right);
}

}  // namespace leadthrough
