#pragma once

// A normal distribution of weights, observed through basis functions.

#include <cstdint>

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

using Columns = Eigen::Matrix<std::int64_t, Eigen::Dynamic, 1>;

struct Conditioned {
  bool
      certain;  // whether an observation was known before to rounding; mean and covariance are void
  Eigen::VectorXd mean;
  Rows covariance;
};

// The weights of curves, one after the other and as many for each as the basis has functions, given
// values of some curves at some phases. basis: a row a phase. columns: the curves observed. values:
// a row a phase, a column a curve. noise: covariance of the values of one phase, or zero. scale:
// what counts as large, a curve. Standard deviations below `least` of it count as known.
Conditioned condition_weights(const VectorRef& mean, const RowsRef& covariance,
                              const RowsRef& basis, const Eigen::Ref<const Columns>& columns,
                              const RowsRef& values, const RowsRef& noise, const VectorRef& scale,
                              double least);

// True if a finite matrix is symmetric and positive semi-definite, to rounding.
bool is_covariance(const RowsRef& matrix);

}  // namespace leadthrough
