#include <gtest/gtest.h>

#include <cmath>

#include "leadthrough/avoidance.hpp"

namespace leadthrough::dmp {
namespace {

using so3::Quaternion;
using so3::Vector3;

const Quaternion kTurned = so3::exp(Vector3(0.4, -0.3, 1.1));

Obstacle obstacle_of(Form form) {
  return {form, Vector3(0.5, 0.02, 0.0), kTurned, Vector3(0.1, 0.2, 0.15), 0.01};
}

TEST(Avoidance, OutwardIsTheGradientOfTheDistance) {
  for (const Form form : {Form::Box, Form::Sphere, Form::Capsule}) {
    const Obstacle obstacle = obstacle_of(form);
    for (const Vector3& point :
         {Vector3(0.9, 0.1, 0.2), Vector3(0.3, -0.4, -0.1), Vector3(0.52, 0.03, 0.01)}) {
      const Clearance here = clearance(obstacle, point);
      EXPECT_NEAR(here.outward.norm(), 1.0, 1e-12);
      const double ahead = clearance(obstacle, point + 1e-6 * here.outward).distance;
      EXPECT_NEAR(ahead - here.distance, 1e-6, 1e-9);
    }
  }
}

TEST(Avoidance, DistancesOfABall) {
  const Obstacle ball{Form::Sphere, Vector3::Zero(), kTurned, Vector3(0.5, 0.0, 0.0), 0.1};
  EXPECT_NEAR(clearance(ball, Vector3(2.0, 0.0, 0.0)).distance, 1.5, 1e-15);
  EXPECT_NEAR(clearance(ball, Vector3(0.0, 0.1, 0.0)).distance, -0.4, 1e-15);
  EXPECT_NEAR(clearance(ball, Vector3::Zero()).outward.norm(), 1.0, 1e-15);
}

// Straight along x from 0 to 1 by minimum jerk, without a learned force.
const Forces kStill{Rows::Zero(2, 3), Vector::Zero(2), 12.5, Canonical::Discrete};

Course straight() {
  Course course{Vector(2), Rows::Zero(6, 3), Vector::Ones(3), Vector::Zero(3)};
  course.breaks << 0, 1;
  course.coefficients.col(0) << 0, 0, 0, 10, -15, 6;
  return course;
}

State rest() { return {Vector::Zero(3), Vector::Zero(3), 0.0}; }

TEST(Avoidance, MotionsKeepTheirMargin) {
  const Vector phases = Vector::LinSpaced(501, 0.0, 1.0);
  for (const Form form : {Form::Box, Form::Sphere, Form::Capsule}) {
    const Obstacle obstacle = obstacle_of(form);
    const Surroundings around{{obstacle}, 0.2, Vector(), Vector()};
    const Passage passage = rollout_around(kStill, straight(), around, rest(), phases);
    double least = 1.0;
    for (Eigen::Index n = 0; n < phases.size(); ++n)
      least = std::min(least, clearance(obstacle, passage.rollout.values.row(n)).distance);
    EXPECT_GT(least, 0.5 * obstacle.margin);
    EXPECT_GT(passage.last_push, 0.2);
    EXPECT_NEAR(passage.rollout.values(500, 0), 1.0, 0.05);
  }
}

TEST(Avoidance, LimitsHoldBackAndLetGo) {
  const Surroundings around{{}, 1.0, Vector::Constant(3, -1.0), Vector::Constant(3, 0.6)};
  const Vector phases = Vector::LinSpaced(501, 0.0, 1.0);
  const Passage passage = rollout_around(kStill, straight(), around, rest(), phases);
  EXPECT_LT(passage.rollout.values.maxCoeff(), 0.6 + 1e-5);  // what finite steps leave
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
  const Surroundings around{{obstacle_of(Form::Sphere)}, 0.2, Vector(), Vector()};
  advance_around(kStill, straight(), around, Vector::Zero(3), 1e6, state);
  EXPECT_LT((state.value - Vector::Unit(3, 0)).norm(), 1e-9);
}

}  // namespace
}  // namespace leadthrough::dmp
