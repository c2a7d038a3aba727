#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "leadthrough/collision/shapes.hpp"

namespace leadthrough::signed_distance_tests {

namespace {

using Eigen::Vector3d;

const Eigen::Matrix3d kTurned =
    Eigen::AngleAxisd(1.2, Vector3d(0.4, -0.3, 1.1).normalized()).toRotationMatrix();
const Convex kBodies[] = {box({0.1, 0.2, 0.15}), sphere(0.1), capsule(0.1, 0.2),
                          cylinder(0.1, 0.2)};

Shape shape_of(const Convex& body) { return {kTurned, {0.5, 0.02, 0.0}, body}; }

TEST(SignedDistance, GrowsAlongItsGradient) {
  for (const Convex& body : kBodies) {
    const Shape shape = shape_of(body);
    for (const Vector3d& point : {Vector3d(0.9, 0.1, 0.2), Vector3d(0.3, -0.4, -0.1),
                                  Vector3d(0.52, 0.03, 0.01), Vector3d(0.48, 0.01, -0.01)}) {
      const SignedDistance here = signed_distance(shape, point);
      EXPECT_NEAR(distance_to(shape, point), here.distance, 1e-14);
      EXPECT_NEAR(here.gradient.norm(), 1.0, 1e-12);
      const double ahead = signed_distance(shape, point + 1e-6 * here.gradient).distance;
      EXPECT_NEAR(ahead - here.distance, 1e-6, 1e-9);
    }
  }
}

// Also at points where every direction is equivalent.
TEST(SignedDistance, GrowsAlongItsGradientFromTheMiddle) {
  for (const Convex& body : kBodies) {
    const Shape shape = shape_of(body);
    const SignedDistance here = signed_distance(shape, shape.position);
    EXPECT_NEAR(here.gradient.norm(), 1.0, 1e-12);
    const double ahead = signed_distance(shape, shape.position + 1e-6 * here.gradient).distance;
    EXPECT_NEAR(ahead - here.distance, 1e-6, 1e-9);
  }
}

TEST(SignedDistance, OfABallIsThatOfItsMiddleLessTheRadius) {
  const Shape ball{kTurned, Vector3d::Zero(), sphere(0.5)};
  EXPECT_NEAR(signed_distance(ball, {2.0, 0.0, 0.0}).distance, 1.5, 1e-15);
  EXPECT_NEAR(signed_distance(ball, {0.0, 0.1, 0.0}).distance, -0.4, 1e-15);
}

TEST(SignedDistance, SizesAreEdgesOrRadiusAndLength) {
  const auto at = [](const char* kind, const Eigen::VectorXd& sizes, double z) {
    return Shape{Eigen::Matrix3d::Identity(), {0.0, 0.0, z}, primitive(kind, sizes).value()};
  };
  const Shape box = at("box", Vector3d(2.0, 4.0, 6.0), 0.0);
  EXPECT_NEAR(signed_distance(box, {0.0, 5.0, 0.0}).distance, 3.0, 1e-15);
  const Shape capsule = at("capsule", Eigen::Vector2d(0.5, 2.0), 1.0);
  EXPECT_NEAR(signed_distance(capsule, {0.0, 0.0, 3.0}).distance, 0.5, 1e-15);
  EXPECT_NEAR(signed_distance(capsule, {0.0, 2.0, 1.5}).distance, 1.5, 1e-15);
  const Shape cylinder = at("cylinder", Eigen::Vector2d(0.5, 2.0), 1.0);
  EXPECT_NEAR(signed_distance(cylinder, {0.0, 0.0, 3.0}).distance, 1.0, 1e-15);
  EXPECT_NEAR(signed_distance(cylinder, {0.0, 2.0, 1.5}).distance, 1.5, 1e-15);
  EXPECT_NEAR(signed_distance(cylinder, {3.5, 0.0, 6.0}).distance, 5.0, 1e-15);
  EXPECT_NEAR(signed_distance(cylinder, {0.1, 0.0, 1.7}).distance, -0.3, 1e-15);
  EXPECT_FALSE(primitive("box", Eigen::Vector2d(0.5, 2.0)));
  EXPECT_FALSE(primitive("cone", Eigen::Vector2d(0.5, 2.0)));
}

// The points of the hulls are its corners, of the cloud the balls' middles.
TEST(SignedDistance, HullsAndCloudsReachAsFarAsTheirFarthestPoint) {
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  const auto some = [&](Eigen::Index count) {
    return Rows3(Rows3::NullaryExpr(count, 3, [&](auto, auto) { return 0.1 * normal(generator); }));
  };
  const Rows3 first = some(9), second = some(7).rowwise() + Eigen::RowVector3d(0.4, -0.2, 0.1);
  Rows3 both(16, 3);
  both << first, second;
  const Vector3d place(0.5, 0.02, 0.3);
  const Shape hulls = make_hulls({first, second}, kTurned, place);
  constexpr double kRadius = 0.03;
  const Shape cloud = make_cloud(std::make_shared<const Cloud>(both, kRadius), kTurned, place);
  const Rows3 placed = (kTurned * both.transpose()).transpose().rowwise() + place.transpose();
  for (int i = 0; i < 20; ++i) {
    const Vector3d along = Vector3d::NullaryExpr([&] { return normal(generator); }).normalized();
    const double farthest = (placed * along).maxCoeff();
    EXPECT_NEAR(hulls.position.dot(along) + reach_of(hulls, along), farthest, 1e-12);
    EXPECT_NEAR(cloud.position.dot(along) + reach_of(cloud, along), farthest + kRadius, 1e-12);
  }
}

}  // namespace

}  // namespace leadthrough::signed_distance_tests
