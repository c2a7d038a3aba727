#include <fcl/narrowphase/distance.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>
#include <type_traits>
#include <vector>

#include "base/allocations.hpp"
#include "base/cases.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/collision/convex_distance.hpp"

namespace leadthrough::convex_distance_tests {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

class Random {
 public:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(generator_);
  }
  Vector3d vector(double reach) {
    return {between(-reach, reach), between(-reach, reach), between(-reach, reach)};
  }
  Transform pose(double reach) {
    const Eigen::Quaterniond turn(between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1));
    return {turn.normalized().toRotationMatrix(), vector(reach)};
  }
  Eigen::Matrix3Xd corners(int count, double reach) {
    Eigen::Matrix3Xd points(3, count);
    for (int i = 0; i < count; ++i) points.col(i) = vector(reach);
    return points;
  }
  Convex body(int kind) {
    const double radius = between(0.02, 0.2);
    const double length = between(0.02, 0.5);
    switch (kind) {
      case 0:
        return sphere(radius);
      case 1:
        return capsule(radius, length);
      case 2:
        return box({radius, length, between(0.02, 0.4)});
      case 3:
        return cylinder(radius, length);
      default:
        return hull(corners(30, 0.2));
    }
  }

 private:
  std::mt19937 generator_{5};
};

Transform at(double x, double y, double z) { return {Matrix3d::Identity(), {x, y, z}}; }

Transform compose(const Transform& a, const Transform& b) {
  return {a.rotation * b.rotation, a.rotation * b.position + a.position};
}

Transform turned(const Vector3d& axis, double angle, const Vector3d& position) {
  return {Eigen::AngleAxisd(angle, axis).toRotationMatrix(), position};
}

std::shared_ptr<fcl::CollisionGeometryd> to_fcl(const Convex& body) {
  if (std::holds_alternative<cores::Point>(body.core))
    return std::make_shared<fcl::Sphered>(body.rounding);
  if (const auto* segment = std::get_if<cores::Segment>(&body.core))
    return std::make_shared<fcl::Capsuled>(body.rounding, 2.0 * segment->half);
  if (const auto* box = std::get_if<cores::Box>(&body.core))
    return std::make_shared<fcl::Boxd>(2.0 * box->half);
  const auto& cylinder = std::get<cores::Cylinder>(body.core);
  return std::make_shared<fcl::Cylinderd>(cylinder.radius, 2.0 * cylinder.half);
}

fcl::CollisionObjectd to_fcl(const Convex& body, const Transform& pose) {
  return {to_fcl(body), pose.rotation, pose.position};
}

double by_fcl(const fcl::CollisionObjectd& a, const fcl::CollisionObjectd& b) {
  fcl::DistanceRequestd request(true);
  request.gjk_solver_type = fcl::GST_LIBCCD;
  request.distance_tolerance = 1e-9;
  fcl::DistanceResultd result;
  return fcl::distance(&a, &b, request, result);
}

struct ReachByDefinition {
  Vector3d d;  // unit

  double operator()(const cores::Point&) const { return 0.0; }
  double operator()(const cores::Segment& core) const { return std::abs(core.half * d.z()); }
  double operator()(const cores::Box& core) const { return core.half.dot(d.cwiseAbs()); }
  double operator()(const cores::Cylinder& core) const {
    return core.radius * std::hypot(d.x(), d.y()) + std::abs(core.half * d.z());
  }
  double operator()(const cores::Hull& core) const {
    return (d.transpose() * core.corners->points()).maxCoeff();
  }
};

double reach(const Convex& body, const Transform& pose, const Vector3d& direction) {
  const ReachByDefinition definition{pose.rotation.transpose() * direction};
  return std::visit(definition, body.core) + body.rounding + direction.dot(pose.position);
}

// The width of the gap that a direction sees between the bodies, below zero where they overlap.
// The largest over all directions is the signed distance.
double gap(const Convex& a, const Transform& A, const Convex& b, const Transform& B,
           const Vector3d& d) {
  return -reach(b, B, -d) - reach(a, A, d);
}

// Climbs from the best of many random directions by ever smaller random steps.
double widest_gap(const Convex& a, const Transform& A, const Convex& b, const Transform& B,
                  Random& random) {
  Vector3d start = Vector3d::UnitX();
  double best = gap(a, A, b, B, start);
  for (int i = 0; i < 100; ++i) {
    const Vector3d d = random.vector(1.0).normalized();
    const double found = gap(a, A, b, B, d);
    if (found <= best) continue;
    best = found;
    start = d;
  }
  for (double step = 0.5; step > 1e-9; step *= 0.6) {
    for (int i = 0; i < 60; ++i) {
      const Vector3d d = (start + random.vector(step)).normalized();
      const double found = gap(a, A, b, B, d);
      if (found <= best) continue;
      best = found;
      start = d;
    }
  }
  return best;
}

}  // namespace

// Whole numbers, so that several corners are equally far.
TEST(Corners, TheFarthestIsTheFirstOfSeveral) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> number(-2, 2);
  const auto vector = [&] { return Vector3d(number(random), number(random), number(random)); };
  for (Eigen::Index count = 4; count < 14; ++count) {
    Eigen::Matrix3Xd points(3, count);
    for (auto point : points.colwise()) point = vector();
    const Corners corners(points);
    for (int k = 0; k < 50; ++k) {
      const Vector3d along = vector();
      Eigen::Index first = 0;
      (along.transpose() * points).maxCoeff(&first);
      EXPECT_EQ(corners.farthest(along), points.col(first));
    }
  }
}

TEST(ConvexDistance, AgreesWithFclWherePrimitivesAreApart) {
  Random random;
  int apart = 0;
  int disagree = 0;
  for (int i = 0; i < 40'000; ++i) {
    const Convex a = random.body(i % 4);
    const Convex b = random.body(i / 4 % 4);
    const Transform A = random.pose(0.4);
    const Transform B = random.pose(0.4);
    const Separation ours = separation(a, A, b, B);
    if (ours.distance <= 1e-4) continue;  // FCL's own tolerance is too coarse
    ++apart;
    const double peer = by_fcl(to_fcl(a, A), to_fcl(b, B));
    // FCL comes within 1e-6 but for one pair in ten thousand. That ours is the distance follows
    // from the points, no farther apart, and the gap across them, no narrower.
    EXPECT_NEAR(ours.distance, peer, 1e-5) << i;
    if (std::abs(ours.distance - peer) > 1e-6) ++disagree;
    const Vector3d way = ours.on_b - ours.on_a;
    EXPECT_NEAR(way.norm(), ours.distance, 1e-9) << i;
    EXPECT_NEAR(gap(a, A, b, B, way.normalized()), ours.distance, 1e-8) << i;
  }
  EXPECT_GT(apart, 25'000);
  EXPECT_LE(disagree, apart / 10'000);
}

TEST(ConvexDistance, DepthIsThatOfTheShallowestDirection) {
  Random random;
  int deep = 0;
  const int count = test::cases(600, 100);
  for (int i = 0; i < count; ++i) {
    const Convex a = random.body(i % 5);
    const Convex b = random.body(i / 5 % 5);
    const Transform A = random.pose(0.1);
    const Transform B = random.pose(0.1);
    const Separation ours = separation(a, A, b, B);
    if (ours.distance >= 0.0) continue;
    ++deep;
    const Vector3d way = (ours.on_a - ours.on_b).normalized();
    // No direction, searched for from many others, sees a wider gap; ours is one of them.
    EXPECT_NEAR(gap(a, A, b, B, way), ours.distance, 1e-6) << i;
    for (int climb = 0; climb < 2; ++climb)
      EXPECT_LE(widest_gap(a, A, b, B, random), ours.distance + 1e-6) << i;
    // Moved apart by the depth along its direction, the bodies touch.
    Transform moved = B;
    moved.position -= ours.distance * way;
    EXPECT_NEAR(separation(a, A, b, moved).distance, 0.0, 1e-6) << i;
  }
  EXPECT_GT(2 * deep, count);
}

TEST(ConvexDistance, TouchingBodiesAreAtZero) {
  const double tolerance = 1e-8;
  const Convex cube = box({0.2, 0.2, 0.2});
  const Convex can = cylinder(0.1, 0.3);
  const Convex ball = sphere(0.1);
  const Convex pill = capsule(0.1, 0.3);
  const Transform origin = at(0, 0, 0);
  EXPECT_NEAR(separation(cube, origin, cube, at(0.2, 0, 0)).distance, 0.0, tolerance);
  EXPECT_NEAR(separation(cube, origin, cube, at(0.2, 0.2, 0.2)).distance, 0.0, tolerance);
  EXPECT_NEAR(separation(cube, origin, can, at(0.05, 0, 0.25)).distance, 0.0, tolerance);
  EXPECT_NEAR(separation(cube, origin, can, at(0.2, 0, 0)).distance, 0.0, tolerance);
  EXPECT_NEAR(separation(can, origin, can, at(0, 0, 0.3)).distance, 0.0, tolerance);
  EXPECT_NEAR(separation(can, origin, can, at(0.2, 0, 0.1)).distance, 0.0, tolerance);
  EXPECT_NEAR(separation(ball, origin, cube, at(0, 0.2, 0)).distance, 0.0, tolerance);
  EXPECT_NEAR(separation(ball, origin, can, at(0, 0, 0.25)).distance, 0.0, tolerance);
  EXPECT_NEAR(separation(ball, origin, pill, at(0.2, 0, 0.1)).distance, 0.0, tolerance);
  EXPECT_NEAR(separation(pill, origin, cube, at(0.2, 0, 0)).distance, 0.0, tolerance);
  EXPECT_NEAR(separation(pill, origin, pill, at(0.2, 0, 0)).distance, 0.0, tolerance);
}

TEST(ConvexDistance, NestedAndCoincidentBodiesHaveTheirDepth) {
  const double tolerance = 1e-7;
  const Convex cube = box({0.2, 0.3, 0.4});
  const Convex can = cylinder(0.1, 0.3);
  const Convex ball = sphere(0.1);
  const Convex pill = capsule(0.1, 0.3);
  const Transform origin = at(0, 0, 0);
  EXPECT_NEAR(separation(cube, origin, cube, origin).distance, -0.2, tolerance);
  EXPECT_NEAR(separation(cube, origin, ball, origin).distance, -0.2, tolerance);
  EXPECT_NEAR(separation(ball, origin, ball, origin).distance, -0.2, tolerance);
  EXPECT_NEAR(separation(pill, origin, pill, origin).distance, -0.2, tolerance);
  EXPECT_NEAR(separation(pill, origin, ball, at(0, 0, 0.1)).distance, -0.2, tolerance);
  EXPECT_NEAR(separation(can, origin, can, origin).distance, -0.2, tolerance);
  EXPECT_NEAR(separation(can, origin, pill, turned(Vector3d::UnitX(), kPi / 2, {0, 0, 0})).distance,
              -0.2, tolerance);
  EXPECT_NEAR(
      separation(box({10, 10, 10}), origin, box({1e-3, 1e-3, 1e-3}), at(4.9, 0, 0)).distance,
      -0.1005, tolerance);
}

TEST(ConvexDistance, ParallelAndCrossingBodiesAreMeasured) {
  const Convex pill = capsule(0.05, 0.4);
  const Convex can = cylinder(0.05, 0.4);
  const Transform origin = at(0, 0, 0);
  const Transform across = turned(Vector3d::UnitX(), kPi / 2, {0.3, 0, 0.1});
  EXPECT_NEAR(separation(pill, origin, pill, at(0.3, 0, 0.1)).distance, 0.2, 1e-12);
  EXPECT_NEAR(separation(pill, origin, pill, at(0, 0, 0.9)).distance, 0.4, 1e-12);
  EXPECT_NEAR(separation(pill, origin, pill, across).distance, 0.2, 1e-12);
  EXPECT_NEAR(separation(can, origin, can, at(0.3, 0, 0.1)).distance, 0.2, 1e-9);
  EXPECT_NEAR(separation(can, origin, can, across).distance, 0.2, 1e-9);
  EXPECT_NEAR(separation(can, origin, pill, across).distance, 0.2, 1e-9);
}

TEST(ConvexDistance, IsSymmetricAndTheSameInEveryFrame) {
  Random random;
  for (int i = 0; i < 5'000; ++i) {
    const Convex a = random.body(i % 5);
    const Convex b = random.body(i / 5 % 5);
    const Transform A = random.pose(0.3);
    const Transform B = random.pose(0.3);
    const Transform frame = random.pose(2.0);
    const double distance = separation(a, A, b, B).distance;
    EXPECT_NEAR(separation(b, B, a, A).distance, distance, 2e-8) << i;
    EXPECT_NEAR(separation(a, compose(frame, A), b, compose(frame, B)).distance, distance, 2e-8)
        << i;
  }
}

TEST(ConvexDistance, NeverGrowsWithTheBodies) {
  Random random;
  for (int i = 0; i < 3'000; ++i) {
    Convex a = random.body(i % 4);
    const Convex b = random.body(i / 4 % 4);
    const Transform A = random.pose(0.3);
    const Transform B = random.pose(0.3);
    const double before = separation(a, A, b, B).distance;
    std::visit(
        [](auto& core) {
          using Own = std::decay_t<decltype(core)>;
          if constexpr (std::is_same_v<Own, cores::Cylinder>) core.radius *= 1.1;
          if constexpr (Own::kClosedForm && !std::is_same_v<Own, cores::Point>) core.half *= 1.1;
        },
        a.core);
    a.rounding *= 1.1;
    EXPECT_LE(separation(a, A, b, B).distance, before + 1e-8) << i;
  }
}

TEST(ConvexDistance, ChangesByNoMoreThanTheBodiesMove) {
  Random random;
  const double step = 2e-4;
  for (int i = 0; i < test::cases(50, 25); ++i) {
    const Convex a = random.body(i % 5);
    const Convex b = random.body(i / 5 % 5);
    const Transform A = random.pose(0.05);
    Transform B = random.pose(0.05);
    const Vector3d way = step * random.vector(1.0).normalized();
    double before = separation(a, A, b, B).distance;
    for (int k = 0; k < 3'000 && before < 0.01; ++k) {  // from deep inside to outside
      B.position += way;
      const double after = separation(a, A, b, B).distance;
      ASSERT_LE(std::abs(after - before), step + 2e-8) << i << " " << k;
      before = after;
    }
  }
}

TEST(ConvexDistance, StopsAtACutoffThatTheBodiesKeep) {
  Random random;
  for (int i = 0; i < 6'000; ++i) {
    const Convex a = random.body(i % 5);
    const Convex b = random.body(i / 5 % 5);
    const double cutoff = i % 2 ? 0.1 : -0.05;  // apart, and deep in each other
    const Transform A = random.pose(i % 2 ? 0.5 : 0.15);
    const Transform B = random.pose(i % 2 ? 0.5 : 0.15);
    const double whole = separation(a, A, b, B).distance;
    const double cut = separation(a, A, b, B, cutoff).distance;
    if (whole < cutoff)
      EXPECT_EQ(cut, whole) << i;
    else
      EXPECT_TRUE(cut >= cutoff && cut <= whole + 1e-9) << i;
  }
}

TEST(ConvexDistance, MeasuresThinBesideHugeBodies) {
  Random random;
  for (int i = 0; i < 5'000; ++i) {
    const Convex a = i % 2 ? box({5.0, 5.0, 2.0}) : cylinder(3.0, 1.0);
    const Convex thin[] = {box({0.3, 1e-4, 1e-4}), cylinder(1e-4, 0.4), cylinder(0.2, 1e-4),
                           capsule(1e-4, 0.5), sphere(1e-4)};
    const Convex& b = thin[i / 2 % 5];
    const Transform A = random.pose(1.0);
    const Transform B = random.pose(4.0);
    const Separation ours = separation(a, A, b, B);
    if (std::abs(ours.distance) < 1e-6) continue;
    const Vector3d way = (ours.on_b - ours.on_a).normalized() * std::copysign(1.0, ours.distance);
    EXPECT_NEAR(gap(a, A, b, B, way), ours.distance, 2e-7) << i;
    EXPECT_NEAR((ours.on_b - ours.on_a).norm(), std::abs(ours.distance), 2e-7) << i;
  }
}

TEST(ConvexDistance, AllocatesNothing) {
  Random random;
  std::vector<Convex> bodies;
  for (int kind = 0; kind < 5; ++kind) bodies.push_back(random.body(kind));
  double sum = 0.0;
  const std::size_t before = test::allocations();
  for (const Convex& a : bodies)
    for (const Convex& b : bodies)
      for (const double reach : {0.05, 1.0})
        sum += separation(a, random.pose(reach), b, random.pose(reach)).distance;
  EXPECT_EQ(test::allocations(), before);
  EXPECT_NE(sum, 0.0);
}

}  // namespace leadthrough::convex_distance_tests
