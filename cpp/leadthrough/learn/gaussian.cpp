#include "leadthrough/learn/gaussian.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "leadthrough/base/argument.hpp"

namespace leadthrough {
namespace {

// Fractions of a matrix' largest entry: computed matrices are symmetric and definite to this only.
constexpr double kRounding = 1e-9;

// Rows of a matrix from one on, by what stays in registers.
struct Lines {
  const double* first;
  Eigen::Index stride;

  explicit Lines(const RowsRef& matrix, Eigen::Index i = 0)
      : first(matrix.data() + i * matrix.outerStride()), stride(matrix.outerStride()) {}

  // Numbers of a row from a column on.
  template <typename Numbers>
  Numbers at(Eigen::Index i, Eigen::Index j) const {
    return Eigen::Map<const Numbers>(first + i * stride + j);
  }
};

// Calls work(j, numbers) from a first column to the end, for two at a time, then for one. Sums of
// so many stay in registers.
template <typename Work>
void in_runs(Eigen::Index first, Eigen::Index end, const Work& work) {
  for (; first + 2 <= end; first += 2) work(first, Eigen::Array<double, 1, 2>());
  if (first < end) work(first, Eigen::Array<double, 1, 1>());
}

constexpr Eigen::Index kTogether = 4;  // rows whose products stay in registers

// From the diagonal on, `Height` rows of a matrix from i on less what their columns of four other
// rows times these rows come to.
template <int Height>
void lower_rows(const RowsRef& matrix, const RowsRef& four, Eigen::Index i, Rows& result) {
  double factors[Height][kTogether];
  for (int r = 0; r < Height; ++r)
    for (Eigen::Index k = 0; k < kTogether; ++k) factors[r][k] = four(k, i + r);
  const Lines from(matrix, i), others(four);
  double* const to = &result(i, 0);
  const Eigen::Index size = result.cols();
  in_runs(i, size, [&](Eigen::Index j, auto numbers) {
    using Numbers = decltype(numbers);
    const auto a = others.template at<Numbers>(0, j), b = others.template at<Numbers>(1, j);
    const auto c = others.template at<Numbers>(2, j), d = others.template at<Numbers>(3, j);
    for (int r = 0; r < Height; ++r) {
      const double* f = factors[r];
      Eigen::Map<Numbers>(to + r * size + j) =
          from.template at<Numbers>(r, j) - (f[0] * a + f[1] * b + f[2] * c + f[3] * d);
    }
  });
}

template <int Height>
void lower_strip(const RowsRef& matrix, const Rows& rows, Eigen::Index i, Rows& result) {
  lower_rows<Height>(matrix, rows.topRows(kTogether), i, result);
  for (Eigen::Index k = kTogether; k < rows.rows(); k += kTogether)
    lower_rows<Height>(result, rows.middleRows(k, kTogether), i, result);
  for (Eigen::Index j = i; j < matrix.rows(); ++j)
    for (int r = 0; r < Height; ++r) result(j, i + r) = result(i + r, j);
}

// A symmetric matrix less what `rows`, a multiple of four, times their own transpose come to;
// symmetric to the bit. With Eigen's rank update, which packs the rows first, the whole of
// condition_weights takes 1.5 times as long (140 weights, 7 rows), 1.1 times for 35 rows.
void lower(const RowsRef& matrix, const Rows& rows, Rows& result) {
  Eigen::Index i = 0;
  for (; i + 2 <= matrix.rows(); i += 2) lower_strip<2>(matrix, rows, i, result);
  if (i < matrix.rows()) lower_strip<1>(matrix, rows, i, result);
}

}  // namespace

Conditioned condition_weights(const VectorRef& mean, const RowsRef& covariance,
                              const RowsRef& basis, const Eigen::Ref<const Columns>& columns,
                              const RowsRef& values, const RowsRef& noise, const VectorRef& scale,
                              double least) {
  const Eigen::Index size = mean.size();
  check_argument(basis.size() > 0 && size % basis.cols() == 0,
                 "basis: expected one column for each weight of a curve");
  check_argument(covariance.rows() == size && covariance.cols() == size,
                 "covariance: expected one row and column for each weight");
  check_argument(columns.size() > 0 && (columns.array() >= 0).all() &&
                     (columns.array() < size / basis.cols()).all(),
                 "columns: expected numbers of curves");
  check_argument(values.rows() == basis.rows() && values.cols() == columns.size(),
                 "values: expected a row for each phase, one column a curve");
  check_argument(noise.rows() == columns.size() && noise.cols() == columns.size() &&
                     scale.size() == columns.size(),
                 "noise, scale: expected one value for each curve");
  const Eigen::Index functions = basis.cols();
  const Eigen::Index curves = columns.size();
  const Eigen::Index observed = basis.rows() * curves;

  // In shares of the scale: covariances of observed values and weights, and the values' surprise.
  const Eigen::Index padded = (observed + kTogether - 1) / kTogether * kTogether;
  Rows padded_spread(padded, mean.size());
  padded_spread.bottomRows(padded - observed).setZero();
  auto spread = padded_spread.topRows(observed);
  Eigen::VectorXd surprise(observed);
  for (Eigen::Index c = 0; c < curves; ++c) {
    const Eigen::Index first = columns[c] * functions;
    for (Eigen::Index i = 0; i < basis.rows(); ++i) {
      const Eigen::Index row = i * curves + c;
      spread.row(row).noalias() = basis.row(i) * covariance.middleRows(first, functions);
      spread.row(row) /= scale[c];
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

bool is_covariance(const RowsRef& matrix) {
  check_argument(matrix.size() > 0 && matrix.rows() == matrix.cols(),
                 "matrix: expected a square one");
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
