#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "leadthrough/collision/ball_cover.hpp"
#include "leadthrough/collision/convex_distance.hpp"

namespace leadthrough::ball_cover_tests {

namespace {

using Eigen::Vector3d;

Convex scattered_hull(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::Matrix3Xd corners(3, 60);
  for (auto corner : corners.colwise())
    corner = Vector3d(0.05 * normal(random), 0.08 * normal(random), 0.2 * normal(random));
  return hull(corners);
}

// An egg of so many corners, as of a mesh from CAD: cut across, all of one side joined to all of
// the other would fill gigabytes.
Convex finely_meshed(std::mt19937& random, Eigen::Index count) {
  std::normal_distribution<double> normal;
  Eigen::Matrix3Xd corners(3, count);
  for (auto corner : corners.colwise()) {
    corner = Vector3d(normal(random), normal(random), normal(random)).normalized();
    corner = corner.cwiseProduct(Vector3d(0.05, 0.06, 0.15));
  }
  return hull(corners);
}

// Distance of a point from a body, negative inside.
double depth(const Convex& body, const Vector3d& point) {
  return separation(sphere(0.0), {Eigen::Matrix3d::Identity(), point}, body, {}).distance;
}

}  // namespace

TEST(BallCover, EveryPointOfABodyIsInAPart) {
  std::mt19937 random(1);
  const std::vector<std::pair<Convex, double>> bodies{{sphere(0.1), 1e-5},
                                                      {capsule(0.05, 0.4), 0.005},
                                                      {cylinder(0.06, 0.3), 0.043},
                                                      {cylinder(0.1, 0.02), 0.091},
                                                      {box({0.1, 0.2, 0.3}), 0.1},
                                                      {scattered_hull(random), 0.15},
                                                      {finely_meshed(random, 20000), 0.05}};
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    SCOPED_TRACE(k);
    const auto& [body, gap] = bodies[k];
    const BallCover cover = ball_cover(body);
    const double reach = cover.whole.radius;
    std::uniform_real_distribution<double> within(-reach, reach);
    int inside = 0;
    for (int i = 0; i < 3000; ++i) {
      const Vector3d point =
          cover.whole.centre + Vector3d(within(random), within(random), within(random));
      double outside = kInfinity;
      for (const Ball& part : cover.parts)
        outside = std::min(outside, (point - part.centre).norm() - part.radius);
      const double distance = depth(body, point);
      // Parts contain the body; at flat ends they stand out by their radius less half a slice.
      if (outside <= 0.0) {
        EXPECT_LE(distance, gap);
      }
      if (distance > 0.0) continue;
      EXPECT_LE(outside, 0.0);
      EXPECT_LE((point - cover.whole.centre).norm(), reach);
      ++inside;
    }
    EXPECT_GT(inside, 50);
  }
}

}  // namespace leadthrough::ball_cover_tests
