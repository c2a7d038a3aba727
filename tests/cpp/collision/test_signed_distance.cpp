#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "collision/signed_distance.hpp"

namespace leadthrough::signed_distance_tests {

namespace {

using Eigen::Vector3d;

const Eigen::Matrix3d kTurned =
    Eigen::AngleAxisd(1.2, Vector3d(0.4, -0.3, 1.1).normalized()).toRotationMatrix();
constexpr ShapeKind kKinds[] = {ShapeKind::kBox, ShapeKind::kSphere, ShapeKind::kCapsule,
                                ShapeKind::kCylinder};

Shape shape_of(ShapeKind kind) {
  return make_shape(kind, {0.1, 0.2, 0.15}, kTurned, {0.5, 0.02, 0.0});
}

TEST(SignedDistance, GrowsAlongItsGradient) {
  for (const ShapeKind kind : kKinds) {
    const Shape shape = shape_of(kind);
    for (const Vector3d& point : {Vector3d(0.9, 0.1, 0.2), Vector3d(0.3, -0.4, -0.1),
                                  Vector3d(0.52, 0.03, 0.01), Vector3d(0.48, 0.01, -0.01)}) {
      const SignedDistance here = signed_distance(shape, point);
      EXPECT_NEAR(here.gradient.norm(), 1.0, 1e-12);
      const double ahead = signed_distance(shape, point + 1e-6 * here.gradient).distance;
      EXPECT_NEAR(ahead - here.distance, 1e-6, 1e-9);
    }
  }
}

// Where every direction is as good as others, too.
TEST(SignedDistance, GrowsAlongItsGradientFromTheMiddle) {
  for (const ShapeKind kind : kKinds) {
    const Shape shape = shape_of(kind);
    const SignedDistance here = signed_distance(shape, shape.position);
    EXPECT_NEAR(here.gradient.norm(), 1.0, 1e-12);
    const double ahead = signed_distance(shape, shape.position + 1e-6 * here.gradient).distance;
    EXPECT_NEAR(ahead - here.distance, 1e-6, 1e-9);
  }
}

TEST(SignedDistance, OfABallIsThatOfItsMiddleLessTheRadius) {
  const Shape ball = make_shape(ShapeKind::kSphere, {0.5, 0.0, 0.0}, kTurned, Vector3d::Zero());
  EXPECT_NEAR(signed_distance(ball, {2.0, 0.0, 0.0}).distance, 1.5, 1e-15);
  EXPECT_NEAR(signed_distance(ball, {0.0, 0.1, 0.0}).distance, -0.4, 1e-15);
}

TEST(SignedDistance, SizesAreEdgesOrRadiusAndLength) {
  const Eigen::Matrix3d straight = Eigen::Matrix3d::Identity();
  const Shape box = make_shape(ShapeKind::kBox, {2.0, 4.0, 6.0}, straight, Vector3d::Zero());
  EXPECT_NEAR(signed_distance(box, {0.0, 5.0, 0.0}).distance, 3.0, 1e-15);
  const Shape capsule = make_shape(ShapeKind::kCapsule, {0.5, 2.0, 0.0}, straight, {0, 0, 1});
  EXPECT_NEAR(signed_distance(capsule, {0.0, 0.0, 3.0}).distance, 0.5, 1e-15);
  EXPECT_NEAR(signed_distance(capsule, {0.0, 2.0, 1.5}).distance, 1.5, 1e-15);
  const Shape cylinder = make_shape(ShapeKind::kCylinder, {0.5, 2.0, 0.0}, straight, {0, 0, 1});
  EXPECT_NEAR(signed_distance(cylinder, {0.0, 0.0, 3.0}).distance, 1.0, 1e-15);
  EXPECT_NEAR(signed_distance(cylinder, {0.0, 2.0, 1.5}).distance, 1.5, 1e-15);
  EXPECT_NEAR(signed_distance(cylinder, {3.5, 0.0, 6.0}).distance, 5.0, 1e-15);
  EXPECT_NEAR(signed_distance(cylinder, {0.1, 0.0, 1.7}).distance, -0.3, 1e-15);
}

}  // namespace

}  // namespace leadthrough::signed_distance_tests
