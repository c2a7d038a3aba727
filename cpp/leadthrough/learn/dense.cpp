#include "leadthrough/learn/dense.hpp"

#include <Eigen/Cholesky>

namespace leadthrough {

Rows product(const Eigen::Ref<const Rows>& left, const Eigen::Ref<const Rows>& right) {
  return left * right;
}

Rows solve_definite(const Eigen::Ref<const Rows>& matrix, const Eigen::Ref<const Rows>& right) {
  const Eigen::LLT<Rows> root(matrix);
  if (root.info() != Eigen::Success) return {};
  return root.solve(right);
}

}  // namespace leadthrough
