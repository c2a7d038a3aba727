#include <gtest/gtest.h>

#include <random>

#include "base/dense.hpp"
#include "leadthrough/learn/gaussian.hpp"

namespace leadthrough::gaussian_tests {

namespace {

Rows random_matrix(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  return Rows::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

}  // namespace

TEST(Gaussian, ConditionedWeightsAreThoseOfBayesRule) {
  const Eigen::Index curves = 3;
  const Eigen::Index functions = 5;
  const Rows root = random_matrix(15, 15, 1);
  const Rows covariance = root * root.transpose();
  const Eigen::VectorXd mean = random_matrix(15, 1, 2);
  const Rows basis = random_matrix(2, functions, 3);
  const Columns columns = (Columns(2) << 2, 0).finished();
  const Rows values = random_matrix(2, 2, 4);
  const Rows noise = (Rows(2, 2) << 0.3, 0.1, 0.1, 0.2).finished();
  const Eigen::Vector2d scale(10.0, 0.01);

  Rows rows = Rows::Zero(4, curves * functions);
  Eigen::VectorXd stacked(4);
  Rows all_noise = Rows::Zero(4, 4);
  for (Eigen::Index i = 0; i < 2; ++i) {
    for (Eigen::Index c = 0; c < 2; ++c) {
      rows.block(2 * i + c, columns[c] * functions, 1, functions) = basis.row(i);
      stacked[2 * i + c] = values(i, c);
    }
    all_noise.block(2 * i, 2 * i, 2, 2) = noise;
  }
  const Rows innovation = rows * covariance * rows.transpose() + all_noise;
  const Rows gain = covariance * rows.transpose() * test::pseudo_inverse(innovation);

  const auto found =
      condition_weights(mean, covariance, basis, columns, values, noise, scale, 1e-9);
  ASSERT_FALSE(found.certain);
  EXPECT_TRUE(found.mean.isApprox(mean + gain * (stacked - rows * mean), 1e-9));
  EXPECT_TRUE(found.covariance.isApprox(covariance - gain * rows * covariance, 1e-9));
}

TEST(Gaussian, ConditionedCovariancesAreSymmetricToTheBit) {
  for (const Eigen::Index size : {1, 2, 5, 9, 14})
    for (const Eigen::Index seen : {1, 2, 4}) {  // up to four rows that are taken together
      const Rows root = random_matrix(size, size, 1);
      const Rows covariance = (root * root.transpose()).selfadjointView<Eigen::Upper>();
      const Rows basis = random_matrix(seen, size, 2);
      const Rows noise = Rows::Identity(1, 1);
      const Rows nothing = Rows::Zero(seen, 1);
      const auto found =
          condition_weights(Eigen::VectorXd::Zero(size), covariance, basis, Columns::Zero(1),
                            nothing, noise, Eigen::VectorXd::Ones(1), 1e-9);
      const Rows innovation = basis * covariance * basis.transpose() + Rows::Identity(seen, seen);
      const Rows gain = covariance * basis.transpose() * test::pseudo_inverse(innovation);
      EXPECT_TRUE(found.covariance.isApprox(covariance - gain * basis * covariance, 1e-9));
      EXPECT_EQ(found.covariance, found.covariance.transpose());
    }
}

TEST(Gaussian, WhatIsKnownAlreadyIsReported) {
  const Rows basis = Rows::Ones(1, 2);
  const Rows none = Rows::Zero(1, 1);
  const auto found =
      condition_weights(Eigen::Vector2d::Zero(), Rows::Zero(2, 2), basis, Columns::Zero(1), none,
                        none, Eigen::VectorXd::Ones(1), 1e-9);
  EXPECT_TRUE(found.certain);
}

TEST(Gaussian, CovariancesAreSymmetricAndSemiDefinite) {
  const Eigen::Vector3d direction(1.0, -2.0, 0.5);
  EXPECT_TRUE(is_covariance(Rows::Zero(2, 2)));
  EXPECT_TRUE(is_covariance(direction * direction.transpose()));
  EXPECT_TRUE(is_covariance(1e-14 * Rows::Identity(3, 3)));
  EXPECT_FALSE(is_covariance(-1e-14 * Rows::Identity(3, 3)));
  EXPECT_FALSE(is_covariance((Rows(2, 2) << 1.0, 0.5, 0.4, 1.0).finished()));
  EXPECT_FALSE(is_covariance((Rows(2, 2) << 1.0, 2.0, 2.0, 1.0).finished()));
}

}  // namespace leadthrough::gaussian_tests
