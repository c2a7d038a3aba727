#include "learn/gaussian.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace leadthrough {
namespace {

// Shares of a matrix' largest entry: what users compute is symmetric and definite to this only.
constexpr double kRounding = 1e-9;

// A symmetric matrix less what `rows`, a multiple of four, times their own transpose come to. Four
// rows at a time, so that sums stay in registers; for few rows a product that packs them first is
// slower. Mirrored in blocks, while they are in the cache.
constexpr Eigen::Index kTogether = 4;
constexpr Eigen::Index kBlock = 8;

void lower(const Eigen::Ref<const Rows>& matrix, const Rows& rows, Rows& result) {
  const Eigen::Index size = matrix.rows();
  for (Eigen::Index first = 0; first < size; first += kBlock) {
    const Eigen::Index count = std::min(kBlock, size - first);
    const Eigen::Index right = size - first - count;
    for (Eigen::Index i = first; i < first + count; ++i) {
      const auto four = [&](Eigen::Index k) {
        const auto row = [&](Eigen::Index l) {
          return rows(l, i) * rows.row(l).tail(size - first);
        };
        return row(k) + row(k + 1) + row(k + 2) + row(k + 3);
      };
      auto line = result.row(i).tail(size - first);
      line = matrix.row(i).tail(size - first) - four(0);
      for (Eigen::Index k = kTogether; k < rows.rows(); k += kTogether) line -= four(k);
    }
    result.block(first + count, first, right, count) =
        result.block(first, first + count, count, right).transpose();
  }
}

}  // namespace

Conditioned condition_weights(const Eigen::Ref<const Eigen::VectorXd>& mean,
                              const Eigen::Ref<const Rows>& covariance,
                              const Eigen::Ref<const Rows>& basis,
                              const Eigen::Ref<const Columns>& columns,
                              const Eigen::Ref<const Rows>& values,
                              const Eigen::Ref<const Rows>& noise,
                              const Eigen::Ref<const Eigen::VectorXd>& scale, double least) {
  const Eigen::Index functions = basis.cols();
  const Eigen::Index curves = columns.size();
  const Eigen::Index observed = basis.rows() * curves;

  // In shares of the scale: covariances of observed values and weights, and the values' surprise.
  // The products are of few rows: written out in place they are quicker than by blocks.
  const Eigen::Index padded = (observed + kTogether - 1) / kTogether * kTogether;
  Rows padded_spread(padded, mean.size());
  padded_spread.bottomRows(padded - observed).setZero();
  auto spread = padded_spread.topRows(observed);
  Eigen::VectorXd surprise(observed);
  for (Eigen::Index c = 0; c < curves; ++c) {
    const Eigen::Index first = columns[c] * functions;
    for (Eigen::Index i = 0; i < basis.rows(); ++i) {
      const Eigen::Index row = i * curves + c;
      spread.row(row) =
          (basis.row(i) / scale[c]).lazyProduct(covariance.middleRows(first, functions));
      surprise[row] = (values(i, c) - basis.row(i).dot(mean.segment(first, functions))) / scale[c];
    }
  }
  Rows innovation(observed, observed);
  for (Eigen::Index c = 0; c < curves; ++c)
    for (Eigen::Index i = 0; i < basis.rows(); ++i)
      innovation.col(i * curves + c) = spread.middleCols(columns[c] * functions, functions)
                                           .lazyProduct(basis.row(i).transpose() / scale[c]);
  const Rows scaled =
      (noise.array().colwise() / scale.array()).rowwise() / scale.transpose().array();
  for (Eigen::Index i = 0; i < basis.rows(); ++i)
    innovation.block(i * curves, i * curves, curves, curves) += scaled;

  const Eigen::LLT<Rows> root(innovation);
  if (root.info() != Eigen::Success || !(root.matrixLLT().diagonal().minCoeff() > least))
    return {true, {}, {}};
  root.matrixL().solveInPlace(spread);
  root.matrixL().solveInPlace(surprise);
  Conditioned result{false, mean, Rows(mean.size(), mean.size())};
  result.mean.noalias() += spread.transpose() * surprise;
  lower(covariance, padded_spread, result.covariance);
  return result;
}

bool is_covariance(const Eigen::Ref<const Rows>& matrix) {
  const double size = matrix.cwiseAbs().maxCoeff();
  if (!((matrix - matrix.transpose()).cwiseAbs().maxCoeff() <= kRounding * size)) return false;
  // No eigenvalue lies below -shift where the matrix with all of them raised by it has a root.
  const double shift = kRounding * size;
  if (!(shift > 0.0)) return true;
  Rows raised = matrix;
  raised.diagonal().array() += shift;
  return Eigen::LLT<Rows>(raised).info() == Eigen::Success;
}

}  // namespace leadthrough
