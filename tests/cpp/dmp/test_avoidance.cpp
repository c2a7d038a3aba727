#include <gtest/gtest.h>

#include <cmath>

#include "leadthrough/dmp/avoidance.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace leadthrough::dmp::avoidance_tests {

namespace {

Obstacle obstacle_of(const Convex& body) {
  const Eigen::Matrix3d turned = so3::to_matrix(so3::exp({0.4, -0.3, 1.1}));
  return {{turned, {0.5, 0.02, 0.0}, body}, 0.01};
}

// Straight along x from 0 to 1 by minimum jerk, without a learned force.
const Forces kStill{Rows::Zero(2, 3), Vector::Zero(2), 12.5, Canonical::kDiscrete};

Course straight() {
  Course course{{Vector(2), Rows::Zero(6, 3)}, Vector::Ones(3), Vector::Zero(3)};
  course.reference.breaks << 0, 1;
  course.reference.coefficients.col(0) << 0, 0, 0, 10, -15, 6;
  return course;
}

State rest() { return {Vector::Zero(3), Vector::Zero(3), 0.0}; }

TEST(Avoidance, MotionsKeepTheirMargin) {
  const Vector phases = Vector::LinSpaced(501, 0.0, 1.0);
  for (const Convex& body :
       {box({0.1, 0.2, 0.15}), sphere(0.1), capsule(0.1, 0.2), cylinder(0.1, 0.2)}) {
    const Obstacle obstacle = obstacle_of(body);
    const AvoidanceScene scene{{obstacle}, 0.2, Vector(), Vector()};
    const Passage passage = rollout_around(kStill, straight(), scene, rest(), phases);
    double least = 1.0;
    for (Eigen::Index n = 0; n < phases.size(); ++n)
      least =
          std::min(least, signed_distance(obstacle.shape, passage.rollout.values.row(n)).distance);
    EXPECT_GT(least, 0.5 * obstacle.margin);
    EXPECT_GT(passage.last_push, 0.2);
    EXPECT_NEAR(passage.rollout.values(500, 0), 1.0, 0.05);
  }
}

TEST(Avoidance, LimitsHoldBackAndLetGo) {
  const AvoidanceScene scene{{}, 1.0, Vector::Constant(3, -1.0), Vector::Constant(3, 0.6)};
  const Vector phases = Vector::LinSpaced(501, 0.0, 1.0);
  const Passage passage = rollout_around(kStill, straight(), scene, rest(), phases);
  EXPECT_LT(passage.rollout.values.maxCoeff(), 0.6 + 1e-5);  // the error of finite steps
  EXPECT_GT(passage.rollout.values(500, 0), 0.59);
}

TEST(Avoidance, NothingInTheWayChangesNothing) {
  const Vector phases = Vector::LinSpaced(101, 0.0, 1.0);
  const Passage passage =
      rollout_around(kStill, straight(), {{}, 1.0, Vector(), Vector()}, rest(), phases);
  const Rollout plain = rollout(kStill, straight(), rest(), phases);
  EXPECT_LT((passage.rollout.values - plain.values).norm(), 1e-12);
  EXPECT_EQ(passage.last_push, 0.0);
}

TEST(Avoidance, LongStepsEndWhereTheSpringsDo) {
  State state = rest();
  const AvoidanceScene scene{{obstacle_of(sphere(0.1))}, 0.2, Vector(), Vector()};
  advance_around(kStill, straight(), scene, Vector::Zero(3), 1e6, state);
  EXPECT_LT((state.value - Vector::Unit(3, 0)).norm(), 1e-9);
}

}  // namespace

}  // namespace leadthrough::dmp::avoidance_tests
