#include <gtest/gtest.h>

#include <cmath>
#include <variant>

#include "arm/robots.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/path/clear_path.hpp"
#include "leadthrough/path/ladder.hpp"

namespace leadthrough::clear_path_tests {

namespace {

// Three bars of 0.4 m in a plane: one joint more than a position in the plane needs.
std::string planar_arm() {
  const std::string bar =
      "<collision><origin xyz='0.2 0 0'/><geometry><box size='0.3 0.04 0.04'/></geometry>"
      "</collision></link>";
  const std::string limit =
      "<axis xyz='0 0 1'/><limit lower='-2.8' upper='2.8' velocity='1' effort='1'/>";
  const std::string next = "<origin xyz='0.4 0 0'/>" + limit;
  return "<robot name='planar'>" + test::link("base") + "<link name='upper'>" + bar +
         "<link name='middle'>" + bar + "<link name='last'>" + bar + test::link("tip") +
         test::joint("j1", "revolute", "base", "upper", limit) +
         test::joint("j2", "revolute", "upper", "middle", next) +
         test::joint("j3", "revolute", "middle", "last", next) +
         test::joint("end", "fixed", "last", "tip", "<origin xyz='0.4 0 0'/>") + "</robot>";
}

struct Planar {
  urdf::Robot robot = std::get<urdf::Robot>(urdf::parse(planar_arm()));
  Chain chain = std::get<Chain>(make_chain(robot, "base", "tip"));
  CollisionModel model = make_collision_model(robot, chain, "base", "tip", {}, {});
  Rows3 positions = Rows3::Zero(41, 3);
  Rows4 no_orientations = Rows4(0, 4);
  Rows postures = Rows::Constant(41, 3, 0.6);
  Rows no_tube = Rows(0, 6);
  IkAxes axes;

  Planar() {
    positions.col(0).setLinSpaced(41, 0.75, 0.55);
    positions.col(1).setLinSpaced(41, 0.1, 0.5);
    axes.free[2] = true;  // nothing moves across the plane
  }

  path::ClearPath among(const PlacedShapes& obstacles) const { return among(obstacles, no_tube); }
  path::ClearPath among(const PlacedShapes& obstacles, const Rows& tube) const {
    return path::find_clear_path(model, obstacles, {positions, no_orientations, axes, tube},
                                 postures, std::nullopt, {0.01, 0.0}, {1e-6, 1e-6});
  }
};

PlacedShapes ball(double x, double y) {
  return {{sphere(0.06), {Eigen::Matrix3d::Identity(), {x, y, 0.0}}}};
}

}  // namespace

TEST(ClearPath, RefusesPathsWhoseLengthIsNotFinite) {
  Planar arm;
  for (const double far : {1e300, kInfinity, std::nan("")}) {
    arm.positions(3, 0) = far;
    EXPECT_THROW(arm.among({}), std::invalid_argument);
  }
}

TEST(ClearPath, LeadsTheElbowAroundABallAndKeepsTheTip) {
  const Planar arm;
  const path::ClearPath free = arm.among({});
  ASSERT_EQ(free.q.rows(), 41);
  // Position of the elbow at half time.
  const double upper = free.q(20, 0);
  const PlacedShapes there = ball(0.4 * std::cos(upper), 0.4 * std::sin(upper));
  EXPECT_TRUE(check_motion(against(arm.model, there), free.q).first.has_value());
  const path::ClearPath found = arm.among(there);
  ASSERT_EQ(found.q.rows(), 41);
  EXPECT_FALSE(check_motion(against(arm.model, there), found.q, {0.01, 1e-4, 1}).first.has_value());
  for (Eigen::Index i = 0; i < 41; ++i) {
    const Transform tip = forward_kinematics(arm.chain, found.q.row(i).data());
    EXPECT_LT((tip.position - arm.positions.row(i).transpose()).norm(), 1e-6);
  }
  for (Eigen::Index i = 1; i < 41; ++i)
    EXPECT_LT((found.q.row(i) - found.q.row(i - 1)).cwiseAbs().maxCoeff(), 0.15);
}

TEST(ClearPath, SaysWhereAndBetweenWhatThereIsNoRoom) {
  const Planar arm;
  // The tip itself is led through the ball in the second half.
  const path::ClearPath found = arm.among(ball(0.6, 0.4));
  EXPECT_EQ(found.q.rows(), 0);
  EXPECT_GT(found.dead_end.sample, 15.0);
  EXPECT_LT(found.dead_end.sample, 30.0);
  EXPECT_FALSE(found.dead_end.pairs.empty());
}

TEST(ClearPath, LeavesThePathWithinATubeWhereThereIsNoRoom) {
  const Planar arm;
  const PlacedShapes there = ball(0.63, 0.38);  // on the tip's way
  ASSERT_EQ(arm.among(there).q.rows(), 0);
  // 20 cm along x and 3 cm along y, none at the ends.
  Rows tube = Rows::Zero(6 * 41, 6);
  for (Eigen::Index i = 1; i < 40; ++i) {
    tube(6 * i, 0) = 0.2 * 0.2;
    tube(6 * i + 1, 1) = 0.03 * 0.03;
  }
  const path::ClearPath found = arm.among(there, tube);
  ASSERT_EQ(found.q.rows(), 41);
  EXPECT_FALSE(check_motion(against(arm.model, there), found.q, {0.01, 1e-4, 1}).first.has_value());
  double most = 0.0;
  for (Eigen::Index i = 0; i < 41; ++i) {
    const Transform tip = forward_kinematics(arm.chain, found.q.row(i).data());
    const Eigen::Vector3d off = tip.position - arm.positions.row(i).transpose();
    const double used = std::hypot(off[0] / 0.2, off[1] / 0.03);
    EXPECT_LE(used, 1.0) << i;
    if (i == 0 || i == 40) {
      EXPECT_LT(off.head<2>().norm(), 1e-6);
    }
    most = std::max(most, used);
  }
  EXPECT_GT(most, 0.2);
}

TEST(ClearPath, IsTheSameEachTime) {
  const Planar arm;
  const PlacedShapes obstacle = ball(0.2, 0.3);
  const path::ClearPath once = arm.among(obstacle);
  const path::ClearPath again = arm.among(obstacle);
  ASSERT_EQ(once.q.rows(), 41);
  EXPECT_EQ(once.q, again.q);
}

TEST(Layers, LieEvenlyAlongTheWay) {
  Rows3 positions = Rows3::Zero(4, 3);
  positions.col(0) << 0.0, 0.1, 0.1, 0.4;  // fast, still, faster
  const auto samples = path::layers({positions, Rows4(0, 4), std::nullopt, Rows(0, 6)}, 0.1, 1.0);
  ASSERT_EQ(samples.size(), 5U);
  const double expected[] = {0.0, 1.0, 2.0 + 1.0 / 3.0, 2.0 + 2.0 / 3.0, 3.0};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(samples[i], expected[i], 1e-12) << i;
}

}  // namespace leadthrough::clear_path_tests
