#include <gtest/gtest.h>

#include <cmath>

#include "leadthrough/rotation/mean.hpp"

namespace leadthrough::mean_tests {

using so3::Quaternion;
using so3::Vector3;

TEST(So3Mean, WeightedMeanOfTwoIsSlerp) {
  const Quaternion a = so3::exp(Vector3(0.1, 0.2, 0.3));
  const Quaternion b = so3::exp(Vector3(-1.0, 0.5, 2.0));
  so3::Quaternions layers(2, 4);
  layers << a.transpose(), -b.transpose();
  const so3::Means result = so3::mean_batch(layers, Eigen::Vector2d(3.0, 1.0));
  EXPECT_LE((Quaternion(result.means.row(0)) - so3::slerp(a, b, 0.25)).norm(), 1e-14);
  EXPECT_NEAR(result.reach[0], so3::distance(a, b) / 2.0, 1e-14);
}

TEST(So3Mean, SymmetricRotationsLeaveTheirCentre) {
  const Quaternion centre = so3::exp(Vector3(2.0, -1.0, 0.5));
  so3::Quaternions layers(8, 4);  // four layers of two columns
  for (int i = 0; i < 4; ++i) {
    const double angle = i * std::acos(0.0);
    const Vector3 offset(std::cos(angle), std::sin(angle), 0.0);
    for (int column = 0; column < 2; ++column)
      layers.row(2 * i + column) =
          so3::compose(centre, so3::exp((column == 0 ? 0.1 : 1.5) * offset));
  }
  const so3::Means result = so3::mean_batch(layers, Eigen::Vector4d::Ones());
  for (int column = 0; column < 2; ++column)
    EXPECT_LE(so3::distance(result.means.row(column), centre), 1e-14);
  EXPECT_NEAR(result.reach[0], 0.1, 1e-14);
  EXPECT_NEAR(result.reach[1], 1.5, 1e-14);
}

TEST(So3Mean, NoColumnsGiveNoMeans) {
  EXPECT_EQ(so3::mean_batch(so3::Quaternions(0, 4), Eigen::Vector2d::Ones()).means.rows(), 0);
}

}  // namespace leadthrough::mean_tests
