#pragma once

// A normal distribution of weights, observed through basis functions.

#include <Eigen/Core>
#include <cstdint>

namespace leadthrough {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Columns = Eigen::Matrix<std::int64_t, Eigen::Dynamic, 1>;

struct Conditioned {
  bool
      certain;  // whether an observation was known before to rounding; mean and covariance are void
  Eigen::VectorXd mean;
  RowMajorMatrix covariance;
};

// The weights of curves, one after the other and as many for each as the basis has functions, given
// values of some curves at some phases. basis: a row a phase. columns: the curves observed. values:
// a row a phase, a column a curve. noise: covariance of the values of one phase, or zero. scale:
// what counts as large, a curve. Standard deviations below `least` of it count as known.
Conditioned condition_weights(const Eigen::Ref<const Eigen::VectorXd>& mean,
                              const Eigen::Ref<const RowMajorMatrix>& covariance,
                              const Eigen::Ref<const RowMajorMatrix>& basis,
                              const Eigen::Ref<const Columns>& columns,
                              const Eigen::Ref<const RowMajorMatrix>& values,
                              const Eigen::Ref<const RowMajorMatrix>& noise,
                              const Eigen::Ref<const Eigen::VectorXd>& scale, double least);

// Whether a finite matrix is symmetric and positive semi-definite, to rounding.
bool is_covariance(const Eigen::Ref<const RowMajorMatrix>& matrix);

}  // namespace leadthrough
