#include <gtest/gtest.h>

#include <cmath>
#include <variant>

#include "arm/robots.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/collision/check.hpp"

namespace leadthrough::check_tests {

using test::joint;

namespace {

std::string round_link(const std::string& name, const std::string& origin,
                       const std::string& geometry) {
  return "<link name='" + name + "'><collision><origin xyz='" + origin + "'/><geometry>" +
         geometry + "</geometry></collision></link>";
}

// Two bars in a plane, a foot that stands still, a ball on a branch of the second bar.
std::string planar_arm() {
  const std::string limit =
      "<axis xyz='0 0 1'/><limit lower='-3.1' upper='3.1' velocity='1' "
      "effort='1'/>";
  const std::string bar = "<box size='1 0.1 0.1'/>";
  return "<robot name='planar'>" + round_link("foot", "-0.5 0 0", "<sphere radius='0.1'/>") +
         round_link("first", "0.5 0 0", bar) + round_link("second", "0.5 0 0", bar) +
         round_link("ball", "0 0 0", "<sphere radius='0.1'/>") + test::link("tip") +
         joint("j1", "revolute", "foot", "first", limit) +
         joint("j2", "revolute", "first", "second", "<origin xyz='1 0 0'/>" + limit) +
         joint("mount", "fixed", "second", "ball", "<origin xyz='1 0 0'/>") +
         joint("end", "fixed", "second", "tip", "<origin xyz='1 0 0'/>") + "</robot>";
}

struct Planar {
  urdf::Robot robot = std::get<urdf::Robot>(urdf::parse(planar_arm()));
  Chain chain = std::get<Chain>(make_chain(robot, "foot", "tip"));
  CollisionModel model = make_collision_model(robot, chain, "foot", "tip", {}, {});
};

Rows rows(std::initializer_list<std::array<double, 2>> values) {
  Rows q(static_cast<Eigen::Index>(values.size()), 2);
  Eigen::Index i = 0;
  for (const auto& row : values) q.row(i++) << row[0], row[1];
  return q;
}

const Transform kOrigin;

Transform at(double x, double y, double z) { return {Eigen::Matrix3d::Identity(), {x, y, z}}; }

}  // namespace

TEST(Collision, EveryLinkHasItsPlaceAndNeighboursAreLeftOut) {
  const Planar arm;
  ASSERT_EQ(arm.model.bodies.size(), 4U);
  EXPECT_EQ(arm.model.bodies[0].frame, 0);
  EXPECT_EQ(arm.model.bodies[1].frame, 1);
  EXPECT_EQ(arm.model.bodies[2].frame + arm.model.bodies[3].frame, 4);
  for (const BodyPair& pair : arm.model.left_out) EXPECT_EQ(pair.why, LeftOut::kAdjacent);
  EXPECT_EQ(arm.model.left_out.size(), 2U);  // foot and first, first and second
  EXPECT_EQ(arm.model.pairs.size(), 3U);     // second and ball with foot, ball with first
}

TEST(Collision, BranchesOfARootWithoutShapesAreNoNeighbours) {
  const std::string limit =
      "<axis xyz='0 0 1'/><limit lower='-1' upper='1' velocity='1' effort='1'/>";
  const std::string bar = "<box size='2 0.1 0.1'/>", ball = "<sphere radius='0.1'/>";
  const auto robot = std::get<urdf::Robot>(urdf::parse(
      "<robot name='branched'>" + test::link("root") + round_link("left", "0 0 0", bar) +
      round_link("right", "0 0 0", ball) + joint("turn", "revolute", "root", "left", limit) +
      joint("mount", "fixed", "root", "right", "<origin xyz='1 0 0'/>") + "</robot>"));
  const Chain chain = std::get<Chain>(make_chain(robot, "root", "left"));
  const CollisionModel model = make_collision_model(robot, chain, "root", "left", {}, {});
  EXPECT_EQ(model.pairs.size(), 1U);
  EXPECT_TRUE(model.left_out.empty());
}

TEST(Collision, DistancesAreThoseOfThePlane) {
  const Planar arm;
  const auto found = nearest_batch(itself(arm.model), rows({{0.0, 0.0}, {0.0, kPi / 2}}), 1);
  EXPECT_NEAR(found[0].distance, 0.9, 1e-9);  // ball at x = 2, bar up to x = 1
  EXPECT_NEAR(found[1].distance, 0.9 - 0.05, 1e-9);
  const auto obstacle = against(arm.model, {{sphere(0.1), at(2.5, 0, 0)}});
  const auto near = nearest_batch(obstacle, rows({{0.0, 0.0}}), 1)[0];
  EXPECT_NEAR(near.distance, 0.3, 1e-9);
  EXPECT_EQ(obstacle.names[static_cast<std::size_t>(near.a)], "obstacle 0");
  EXPECT_EQ(obstacle.names[static_cast<std::size_t>(near.b)], "ball");
}

TEST(Collision, WhatStandsStillIsNotCheckedAgainstObstacles) {
  const Planar arm;
  const auto found =
      nearest_batch(against(arm.model, {{sphere(0.2), at(-0.5, 0, 0)}}), rows({{0.0, 0.0}}), 1);
  EXPECT_NEAR(found[0].distance, 0.3, 1e-9);  // to the first bar, not to the foot
}

TEST(Collision, AttachedShapesMoveWithTheTip) {
  const Planar arm;
  const PlacedShapes rod{{capsule(0.05, 1.0), at(0, 0, 0.6)}};
  const auto model = make_collision_model(arm.robot, arm.chain, "foot", "tip", {}, rod);
  EXPECT_EQ(model.bodies.back().name, "attached");
  const auto above = against(model, {{sphere(0.1), at(2.0, 0, 1.5)}});
  EXPECT_NEAR(nearest_batch(above, rows({{0.0, 0.0}}), 1)[0].distance, 0.4 - 0.15, 1e-9);
}

TEST(Collision, NothingIsPassedThroughBetweenRows) {
  const Planar arm;
  const Rows q = rows({{-1.2, 0.0}, {1.2, 0.0}});
  const auto wall = against(arm.model, {{box({0.01, 1e-3, 1e-3}), at(2.0, 0, 0)}});
  const MotionReport report = check_motion(wall, q);
  EXPECT_GT(report.samples[0].distance, 0.5);
  EXPECT_GT(report.samples[1].distance, 0.5);
  ASSERT_TRUE(report.first);
  EXPECT_LT(report.first->nearest.distance, 0.0);
  EXPECT_GT(report.first->sample, 0.47);
  EXPECT_LT(report.first->sample, 0.5);
  EXPECT_LT(report.closest.nearest.distance, -0.1);
}

TEST(Collision, RowsThatAreNotFiniteAreRefused) {
  const Planar arm;
  const auto wall = against(arm.model, {{sphere(0.1), at(2.0, 0, 0)}});
  for (const double wrong : {kInfinity, std::nan("")})
    EXPECT_THROW(check_motion(wall, rows({{0.1, 0.2}, {wrong, 0.2}})), std::invalid_argument);
}

TEST(Collision, NoRowsHaveNoStepBetweenThem) {
  const Planar arm;
  const auto wall = against(arm.model, {{sphere(0.1), at(2.0, 0, 0)}});
  EXPECT_EQ(longest_step(wall, Rows(0, 2)), 0.0);
  EXPECT_EQ(longest_step(wall, rows({{0.1, 0.2}})), 0.0);
}

TEST(Collision, AHullIsWhereItsMeshIs) {
  const std::string mesh = "<mesh filename='cube.stl'/>";
  const std::string text = "<robot name='r'>" + test::link("a") + round_link("b", "1 0 0", mesh) +
                           joint("j", "continuous", "a", "b", "<axis xyz='0 0 1'/>") + "</robot>";
  const auto robot = std::get<urdf::Robot>(urdf::parse(text));
  const auto chain = std::get<Chain>(make_chain(robot, "a", "b"));
  Eigen::Matrix3Xd corners(3, 8);  // of a cube about (5, 0, 0)
  for (int i = 0; i < 8; ++i)
    corners.col(i) << 5.0 + (i & 1 ? 0.5 : -0.5), i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5;
  const auto model = make_collision_model(robot, chain, "a", "b", {{corners}}, {});
  const auto scene = against(model, {{sphere(0.5), kOrigin}});
  EXPECT_NEAR(nearest_batch(scene, Rows::Zero(1, 1), 1)[0].distance, 5.0, 1e-9);
}

}  // namespace leadthrough::check_tests
