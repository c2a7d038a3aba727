// Clouds against what all their balls say one by one.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "base/allocations.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/collision/cloud.hpp"
#include "leadthrough/collision/shapes.hpp"

namespace leadthrough::cloud_tests {

namespace {

using Eigen::Vector3d;

constexpr double kRadius = 0.01;

class Random {
 public:
  Vector3d vector(double most) {
    std::uniform_real_distribution<double> uniform(-most, most);
    return {uniform(engine_), uniform(engine_), uniform(engine_)};
  }
  Transform pose(double most) {
    return {Eigen::Quaterniond::UnitRandom().toRotationMatrix(), vector(most)};
  }

 private:
  std::mt19937 engine_{5};
};

// A bent sheet, a few clumps of the same point and strays, as cameras see them.
Rows3 scattered(Random& random, int count) {
  Rows3 points(count, 3);
  for (int i = 0; i < count; ++i) {
    const Vector3d p = random.vector(0.5);
    if (i % 10 == 0)
      points.row(i) = p;
    else if (i % 10 == 1)
      points.row(i) << 0.3, 0.2, 0.1;
    else
      points.row(i) << p.x(), p.y(), 0.2 * std::sin(4.0 * p.x());
  }
  return points;
}

std::vector<Convex> bodies() {
  Eigen::Matrix3Xd corners = Eigen::Matrix3Xd::Random(3, 30) * 0.1;
  return {sphere(0.05), capsule(0.04, 0.2), box({0.1, 0.05, 0.2}), cylinder(0.05, 0.15),
          hull(corners)};
}

TEST(Cloud, IsAsFarAsItsNearestBall) {
  Random random;
  for (const int count : {1, 7, 8, 9, 600}) {
    const Rows3 points = scattered(random, count);
    const Cloud cloud(points, kRadius);
    for (const Convex& body : bodies()) {
      const double radius = bounding_radius(body);
      for (int i = 0; i < 20; ++i) {
        const Transform own = random.pose(0.2), other = random.pose(0.7);
        double least = kInfinity;
        for (int k = 0; k < count; ++k) {
          const Vector3d local = points.row(k).transpose() - cloud.middle();
          const Transform at{Eigen::Matrix3d::Identity(), own.rotation * local + own.position};
          least = std::min(least, separation(sphere(kRadius), at, body, other).distance);
        }
        const Separation found = cloud.separation(own, body, other, radius, kInfinity);
        EXPECT_NEAR(found.distance, least, 2e-8);
        EXPECT_NEAR(found.normal.norm(), 1.0, 1e-12);
        EXPECT_NEAR((found.on_b - found.on_a).norm(), std::abs(least), 1e-6);
        EXPECT_TRUE(cloud.apart(own, body, other, radius, least - 1e-6));
        EXPECT_FALSE(cloud.apart(own, body, other, radius, least + 1e-6));
        EXPECT_GE(cloud.separation(own, body, other, radius, least - 1e-6).distance, least - 1e-6);
        EXPECT_NEAR(cloud.separation(own, body, other, radius, least + 1e-6).distance, least, 2e-8);
      }
    }
  }
}

TEST(Cloud, AllocatesNothing) {
  Random random;
  const Rows3 points = scattered(random, 300);
  const Cloud cloud(points, kRadius);
  const std::vector<Convex> all = bodies();
  const Transform own = random.pose(0.2), other = random.pose(0.3);
  const std::size_t before = test::allocations();
  for (const Convex& body : all) {
    cloud.separation(own, body, other, 0.5, kInfinity);
    cloud.apart(own, body, other, 0.5, 0.1);
  }
  EXPECT_EQ(test::allocations(), before);
}

TEST(Cloud, IsNearestToFinitePointsAlone) {
  Random random;
  const Cloud cloud(scattered(random, 20), kRadius);
  EXPECT_LE(cloud.nearest_to({1e30, 0.0, 0.0}).norm(), 1.0);
  for (const double far : {1e300, kInfinity, std::nan("")})
    EXPECT_THROW(cloud.nearest_to({far, 0.0, 0.0}), std::invalid_argument);
}

TEST(Cloud, LiesInItsBall) {
  Random random;
  const Rows3 points = scattered(random, 500);
  const Cloud cloud(points, kRadius);
  for (int k = 0; k < points.rows(); ++k) {
    const Vector3d local = points.row(k).transpose() - cloud.middle();
    EXPECT_LE(local.norm() + kRadius, cloud.bounding_radius() + 1e-12);
    EXPECT_EQ(cloud.nearest_to(local), local);
    EXPECT_GE(cloud.reach(local.normalized()), local.norm() + kRadius - 1e-12);
  }
}

TEST(SignedDistance, OfHullsAndCloudsGrowsAlongItsGradient) {
  Random random;
  std::vector<Rows3> corners;
  for (const Vector3d& centre : {Vector3d(0.3, 0.0, 0.0), Vector3d(-0.3, 0.1, 0.0)}) {
    corners.emplace_back(8, 3);
    for (int i = 0; i < 8; ++i)
      corners.back().row(i) =
          centre.transpose() + Eigen::RowVector3d(i & 1, (i >> 1) & 1, i >> 2) * 0.1;
  }
  const Eigen::Matrix3d turned = Eigen::Quaterniond::UnitRandom().toRotationMatrix();
  const Rows3 points = scattered(random, 300);
  for (const Shape& shape :
       {make_hulls(corners, turned, {0.1, 0.2, 0.3}),
        make_cloud(std::make_shared<const Cloud>(points, kRadius), turned, {0.1, 0.2, 0.3})}) {
    for (int i = 0; i < 300; ++i) {
      const Vector3d point = shape.position + random.vector(0.6);
      const SignedDistance here = signed_distance(shape, point);
      EXPECT_NEAR(here.gradient.norm(), 1.0, 1e-9);
      const double ahead = signed_distance(shape, point + 1e-4 * here.gradient).distance;
      const double behind = signed_distance(shape, point - 1e-4 * here.gradient).distance;
      // Beside an edge of the medial axis another part is nearer a step ahead.
      EXPECT_LE(std::abs(ahead - here.distance), 1e-4 + 1e-7);
      EXPECT_NEAR(here.distance - behind, 1e-4, 2e-7);
    }
  }
}

}  // namespace

}  // namespace leadthrough::cloud_tests
