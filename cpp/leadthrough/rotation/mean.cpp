#include "leadthrough/rotation/mean.hpp"

#include <algorithm>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/base/orthogonal.hpp"

namespace leadthrough::so3 {

namespace {

// Every step is a fraction of the one before, so the remaining error is below this too.
constexpr double kLastStep = 1e-14;  // rad
constexpr int kMaxSteps = 100;

// The rotations that go into one mean: rows `first`, `first + stride`, ... of all layers.
struct Column {
  const Rows4Ref& layers;
  Eigen::Index first, stride, count;

  Quaternion operator[](Eigen::Index i) const { return layers.row(first + i * stride); }
};

// Markley et al. 2007, "Averaging quaternions": the mean of the chordal distance.
template <typename Weights>
Quaternion chordal_mean(const Column& column, const Weights& weights) {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (Eigen::Index i = 0; i < column.count; ++i) {
    const Quaternion q = column[i];
    sum += weights[i] * q * q.transpose();
  }
  Eigen::Matrix4d vectors = Eigen::Matrix4d::Identity();
  orthogonalize_columns(sum, vectors);
  Eigen::Index largest;
  sum.colwise().squaredNorm().maxCoeff(&largest);
  return vectors.col(largest);
}

double largest_distance(const Column& column, const Quaternion& from) {
  double largest = 0.0;
  for (Eigen::Index i = 0; i < column.count; ++i)
    largest = std::max(largest, distance(from, column[i]));
  return largest;
}

// Gauss-Newton in the tangent space. The Hessian is at most the identity, so no step overshoots.
Quaternion karcher_mean(const Column& column, const VectorRef& weights) {
  const double total = weights.sum();
  Quaternion mean = chordal_mean(column, weights);
  for (int steps = 0; steps < kMaxSteps; ++steps) {
    Vector3 step = Vector3::Zero();
    for (Eigen::Index i = 0; i < column.count; ++i) {
      check_interrupt(i);
      step += weights[i] / total * log(compose(inverse(mean), column[i]));
    }
    mean = compose(mean, exp(step)).normalized();
    if (step.norm() <= kLastStep) break;
  }
  return column[0].dot(mean) < 0.0 ? Quaternion(-mean) : mean;
}

}  // namespace

Means mean_batch(const Rows4Ref& layers, const VectorRef& weights) {
  check_argument(weights.size() > 0 && layers.rows() % weights.size() == 0,
                 "layers: expected as many layers as weights");
  const Eigen::Index count = weights.size();
  const Eigen::Index columns = layers.rows() / count;
  const Eigen::VectorXd equal = Eigen::VectorXd::Ones(count);
  Means result{Quaternions(columns, 4), Eigen::VectorXd(columns)};
  for (Eigen::Index i = 0; i < columns; ++i) {
    check_interrupt();
    const Column column{layers, i, columns, count};
    result.reach[i] = largest_distance(column, chordal_mean(column, equal));
    result.means.row(i) = karcher_mean(column, weights);
  }
  return result;
}

}  // namespace leadthrough::so3
