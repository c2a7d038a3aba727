#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "leadthrough/path/band.hpp"

namespace leadthrough::band_tests {

using path::BandMatrix;

namespace {

// A random positive definite matrix with that many diagonals below the main one.
Eigen::MatrixXd random_matrix(int size, int width) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
  for (int i = 0; i < size; ++i)
    for (int j = std::max(0, i - width); j <= i; ++j) matrix(i, j) = matrix(j, i) = uniform(random);
  matrix.diagonal().array() += 2.0 * width + 1.0;
  return matrix;
}

BandMatrix banded(const Eigen::MatrixXd& matrix, int width) {
  BandMatrix band(static_cast<int>(matrix.rows()), width);
  for (int i = 0; i < matrix.rows(); ++i)
    for (int j = std::max(0, i - width); j <= i; ++j) band.at(i, j) = matrix(i, j);
  return band;
}

}  // namespace

TEST(BandMatrix, SolvesAsDenseMatricesDo) {
  for (const int width : {0, 2, 7}) {
    const Eigen::MatrixXd matrix = random_matrix(40, width);
    const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(40, -1.0, 2.0);
    Eigen::VectorXd x = right;
    ASSERT_TRUE(banded(matrix, width).solve(x));
    EXPECT_LT((x - matrix.llt().solve(right)).norm(), 1e-12);
  }
}

TEST(BandMatrix, TakesAnUnknownOut) {
  const Eigen::MatrixXd matrix = random_matrix(12, 3);
  BandMatrix band = banded(matrix, 3);
  Eigen::VectorXd x = Eigen::VectorXd::Ones(12);
  x[5] = 0.0;
  band.hold(5);
  ASSERT_TRUE(band.solve(x));
  EXPECT_EQ(x[5], 0.0);
  Eigen::VectorXd left = matrix * x;
  left[5] = 1.0;
  EXPECT_LT((left - Eigen::VectorXd::Ones(12)).norm(), 1e-12);
}

TEST(BandMatrix, SaysWhereItIsNotPositive) {
  BandMatrix band(2, 1);
  band.at(0, 0) = 1.0;
  band.at(1, 0) = 2.0;
  band.at(1, 1) = 1.0;
  Eigen::VectorXd x = Eigen::VectorXd::Ones(2);
  EXPECT_FALSE(band.solve(x));
}

}  // namespace leadthrough::band_tests
