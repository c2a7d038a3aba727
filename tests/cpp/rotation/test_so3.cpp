#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace leadthrough::so3_tests {

using so3::Quaternion;
using so3::Vector3;

namespace {

Vector3 random_direction(std::mt19937& generator) {
  std::normal_distribution<double> normal;
  return Vector3(normal(generator), normal(generator), normal(generator)).normalized();
}

}  // namespace

TEST(So3, LogInvertsExpUpToPi) {
  std::mt19937 generator(1);
  for (const double angle : {0.0, 1e-300, 1e-12, 1e-5, 1.9e-4, 2.1e-4, 0.1, 1.0, 3.0, 3.14159}) {
    const Vector3 vector = angle * random_direction(generator);
    EXPECT_LE((so3::log(so3::exp(vector)) - vector).norm(), 1e-15 + 4e-16 * angle) << angle;
  }
}

TEST(So3, ExpHasUnitLengthForAnyVector) {
  std::mt19937 generator(2);
  for (const double angle : {1e-8, 1.0, kPi, 2 * kPi, 100.0})
    EXPECT_NEAR(so3::exp(angle * random_direction(generator)).norm(), 1.0, 1e-15);
}

TEST(So3, LogAtPiHasLengthPiWhateverTheSign) {
  const Quaternion half_turn(0.0, 0.6, 0.0, 0.8);
  EXPECT_NEAR(so3::log(half_turn).norm(), kPi, 1e-15);
  EXPECT_NEAR(so3::log(-half_turn).norm(), kPi, 1e-15);
}

TEST(So3, LogIgnoresSignAndLength) {
  const Quaternion q = so3::exp(Vector3(0.3, -0.2, 1.1));
  EXPECT_LE((so3::log(-3.0 * q) - Vector3(0.3, -0.2, 1.1)).norm(), 1e-15);
}

TEST(So3, ComposeTurnsBFirst) {
  const Quaternion a = so3::exp(Vector3(0, 0, kPi / 2));
  const Quaternion b = so3::exp(Vector3(kPi / 2, 0, 0));
  EXPECT_LE((so3::to_matrix(so3::compose(a, b)) - so3::to_matrix(a) * so3::to_matrix(b)).norm(),
            1e-15);
}

TEST(So3, DistanceIsTheAngleBetween) {
  const Quaternion a = so3::exp(Vector3(0.1, 0.2, 0.3));
  const Quaternion b = so3::compose(a, so3::exp(Vector3(0, 2.0, 0)));
  EXPECT_NEAR(so3::distance(a, b), 2.0, 1e-15);
  EXPECT_NEAR(so3::distance(a, -b), 2.0, 1e-15);
  EXPECT_EQ(so3::distance(a, a), 0.0);
}

TEST(So3, MatrixAndBackNearEveryBranch) {
  std::mt19937 generator(3);
  for (const double angle : {0.0, 1e-9, 1.0, kPi - 1e-9, kPi}) {
    for (int repeat = 0; repeat < 50; ++repeat) {
      const Quaternion q = so3::exp(angle * random_direction(generator));
      EXPECT_LE(so3::distance(so3::from_matrix(so3::to_matrix(q)), q), 1e-15);
    }
  }
}

}  // namespace leadthrough::so3_tests
