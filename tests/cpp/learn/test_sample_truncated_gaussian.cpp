#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/learn/sample_truncated_gaussian.hpp"

namespace leadthrough::sample_truncated_gaussian_tests {

namespace {

constexpr Eigen::Index kDraws = 20000;

Rows velocities(Eigen::Index size) {
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  return Rows::NullaryExpr(kDraws, size, [&] { return normal(generator); });
}

}  // namespace

TEST(Bouncing, WithoutAWallInReachTheDrawsAreTheVelocities) {
  const Rows drawn =
      sample_truncated_gaussian(Rows::Identity(2, 2), Eigen::Vector2d::Constant(100.0),
                                Eigen::Vector2d(3.0, -2.0), velocities(2));
  EXPECT_TRUE(drawn.isApprox(velocities(2), 1e-12));
}

TEST(Bouncing, BehindOneWallIsHalfANormalDistribution) {
  Rows wall(1, 2);
  wall << 3.0, 4.0;
  const Rows drawn = sample_truncated_gaussian(wall, Eigen::VectorXd::Zero(1),
                                               Eigen::Vector2d(-0.3, -0.4), velocities(2));
  const Eigen::ArrayXd along = drawn * wall.row(0).transpose() / 5.0;
  EXPECT_LE(along.maxCoeff(), 1e-12);
  EXPECT_NEAR(along.mean(), -std::sqrt(2.0 / kPi), 0.02);
  EXPECT_NEAR(along.square().mean(), 1.0, 0.03);
}

TEST(Bouncing, ANarrowWedgeIsNeverLeft) {
  Rows walls(3, 2);
  walls << 1.0, 0.05, -1.0, 0.05, 0.0, -1.0;
  const Eigen::Vector3d limits(0.02, 0.02, 2.0);
  const Rows drawn =
      sample_truncated_gaussian(walls, limits, Eigen::Vector2d(0.0, -1.0), velocities(2));
  const Eigen::VectorXd outside = (drawn * walls.transpose()).colwise().maxCoeff();
  EXPECT_LE((outside - limits).maxCoeff(), 1e-9);
}

}  // namespace leadthrough::sample_truncated_gaussian_tests
