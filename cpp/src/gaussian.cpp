#include "leadthrough/gaussian.hpp"

#include <Eigen/Cholesky>

namespace leadthrough {

Conditioned condition_weights(const Eigen::Ref<const Eigen::VectorXd>& mean,
                              const Eigen::Ref<const RowMajorMatrix>& covariance,
                              const Eigen::Ref<const RowMajorMatrix>& basis,
                              const Eigen::Ref<const Columns>& columns,
                              const Eigen::Ref<const RowMajorMatrix>& values,
                              const Eigen::Ref<const RowMajorMatrix>& noise,
                              const Eigen::Ref<const Eigen::VectorXd>& scale, double least) {
  const Eigen::Index functions = basis.cols();
  const Eigen::Index curves = columns.size();
  const Eigen::Index observed = basis.rows() * curves;

  // In shares of the scale: covariances of observed values and weights, and the values' surprise.
  RowMajorMatrix spread(observed, mean.size());
  Eigen::VectorXd surprise(observed);
  for (Eigen::Index c = 0; c < curves; ++c) {
    const Eigen::Index first = columns[c] * functions;
    for (Eigen::Index i = 0; i < basis.rows(); ++i) {
      const Eigen::Index row = i * curves + c;
      spread.row(row).noalias() = basis.row(i) * covariance.middleRows(first, functions) / scale[c];
      surprise[row] = (values(i, c) - basis.row(i).dot(mean.segment(first, functions))) / scale[c];
    }
  }
  RowMajorMatrix innovation(observed, observed);
  for (Eigen::Index c = 0; c < curves; ++c)
    for (Eigen::Index i = 0; i < basis.rows(); ++i)
      innovation.col(i * curves + c).noalias() =
          spread.middleCols(columns[c] * functions, functions) * basis.row(i).transpose() /
          scale[c];
  const RowMajorMatrix scaled =
      (noise.array().colwise() / scale.array()).rowwise() / scale.transpose().array();
  for (Eigen::Index i = 0; i < basis.rows(); ++i)
    innovation.block(i * curves, i * curves, curves, curves) += scaled;

  const Eigen::LLT<RowMajorMatrix> root(innovation);
  if (root.info() != Eigen::Success || !(root.matrixLLT().diagonal().minCoeff() > least))
    return {true, {}, {}};
  root.matrixL().solveInPlace(spread);
  root.matrixL().solveInPlace(surprise);
  Conditioned result{false, mean, covariance};
  result.mean.noalias() += spread.transpose() * surprise;
  result.covariance.selfadjointView<Eigen::Lower>().rankUpdate(spread.transpose(), -1.0);
  result.covariance.triangularView<Eigen::StrictlyUpper>() = result.covariance.transpose();
  return result;
}

}  // namespace leadthrough
