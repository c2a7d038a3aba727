#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <random>

#include "arm/kdl_chain.hpp"
#include "arm/robots.hpp"
#include "leadthrough/arm/chain.hpp"

namespace leadthrough::chain_tests {

namespace {

urdf::Robot crooked_robot() { return std::get<urdf::Robot>(urdf::parse(test::crooked_arm())); }

std::string why(const std::variant<Chain, urdf::Error>& answer) {
  return std::get<urdf::Error>(answer).why;
}

}  // namespace

TEST(Chain, KinematicsAgreeWithKdl) {
  const urdf::Robot robot = crooked_robot();
  const Chain chain = std::get<Chain>(make_chain(robot, "l0", "l9"));
  const KDL::Chain peer = test::kdl_chain(robot, "l0", "l9");
  KDL::ChainFkSolverPos_recursive forward(peer);
  KDL::ChainJntToJacSolver to_jacobian(peer);
  ASSERT_EQ(chain.joints(), static_cast<int>(peer.getNrOfJoints()));
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(-3.0, 3.0);
  for (int repeat = 0; repeat < 200; ++repeat) {
    KDL::JntArray q(peer.getNrOfJoints());
    for (unsigned i = 0; i < q.rows(); ++i) q(i) = uniform(generator);
    KDL::Frame frame;
    KDL::Jacobian jacobian(peer.getNrOfJoints());
    ASSERT_EQ(forward.JntToCart(q, frame), 0);
    ASSERT_EQ(to_jacobian.JntToJac(q, jacobian), 0);
    Kinematics ours;
    forward_kinematics(chain, q.data.data(), ours);
    for (int row = 0; row < 3; ++row) {
      EXPECT_NEAR(ours.T_base_tip.position[row], frame.p[row], 1e-13);
      for (int col = 0; col < 3; ++col)
        EXPECT_NEAR(ours.T_base_tip.rotation(row, col), frame.M(row, col), 1e-13);
    }
    for (unsigned i = 0; i < q.rows(); ++i)
      EXPECT_LE((ours.jacobian[i] - jacobian.data.col(i)).norm(), 1e-12);
    EXPECT_EQ(forward_kinematics(chain, q.data.data()).position, ours.T_base_tip.position);
  }
}

TEST(Chain, MayStartAndEndInside) {
  const Chain chain = std::get<Chain>(make_chain(crooked_robot(), "l1", "l5"));
  EXPECT_EQ(chain.joint_names, (std::vector<std::string>{"j1", "j2", "j3"}));
}

TEST(Chain, RefusesLinksThatDoNotExistOrDoNotHangTogether) {
  const urdf::Robot robot = crooked_robot();
  EXPECT_EQ(why(make_chain(robot, "nowhere", "l9")), "no link is named 'nowhere'");
  EXPECT_EQ(why(make_chain(robot, "l0", "nowhere")), "no link is named 'nowhere'");
  EXPECT_EQ(why(make_chain(robot, "l9", "l0")), "'l0' does not hang from 'l9'");
  EXPECT_EQ(why(make_chain(robot, "l8", "l9")), "no joint moves between base and tip");
}

TEST(Chain, RefusesTooManyJoints) {
  std::string text = "<robot name='snake'>" + test::link("l0");
  for (int i = 0; i < kMaxJoints + 1; ++i)
    text += test::link("l" + std::to_string(i + 1)) +
            test::joint("j" + std::to_string(i), "continuous", "l" + std::to_string(i),
                        "l" + std::to_string(i + 1), "<axis xyz='0 0 1'/>");
  const auto robot = std::get<urdf::Robot>(urdf::parse(text + "</robot>"));
  EXPECT_TRUE(std::holds_alternative<Chain>(make_chain(robot, "l0", "l16")));
  EXPECT_EQ(why(make_chain(robot, "l0", "l17")),
            "17 joints move between base and tip; at most 16 are supported");
}

namespace {

// a - one - b - two - c - three - d, with what the joints have inside.
urdf::Robot three_joints(const std::string& one, const std::string& two,
                         const std::string& three = "<axis xyz='0 1 0'/>") {
  return std::get<urdf::Robot>(urdf::parse(
      "<robot name='r'>" + test::link("a") + test::link("b") + test::link("c") + test::link("d") +
      test::joint("one", "continuous", "a", "b", "<origin xyz='0.1 0 0.2'/>" + one) +
      test::joint("two", "prismatic", "b", "c", "<origin xyz='0 0.3 0' rpy='1 0 0'/>" + two) +
      test::joint("three", "continuous", "c", "d", "<origin xyz='0.2 0 0'/>" + three) +
      "</robot>"));
}

const std::string kAxis = "<axis xyz='0 0 1'/>";
const std::string kLimit = "<limit lower='-1' upper='0.5' velocity='3' effort='9'/>";

}  // namespace

TEST(Chain, RefusesJointsThatFloat) {
  const auto robot = std::get<urdf::Robot>(
      urdf::parse("<robot name='r'>" + test::link("a") + test::link("b") + test::link("c") +
                  test::joint("one", "continuous", "a", "b", kAxis) +
                  test::joint("two", "floating", "b", "c", "") + "</robot>"));
  EXPECT_EQ(why(make_chain(robot, "a", "c")),
            "planar and floating joints cannot be part of an arm");
}

TEST(Chain, RefusesNegativeMassesAndMomentsOfLinksThatItMoves) {
  // To "b", which has the inertia, and to "c" beside it.
  const auto arm = [](const std::string& mass, const std::string& ixx, const std::string& tip) {
    return make_chain(
        std::get<urdf::Robot>(urdf::parse(
            "<robot name='r'>" + test::link("a") + "<link name='b'><inertial><mass value='" + mass +
            "'/><inertia ixx='" + ixx + "' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>" +
            "</link>" + test::link("c") + test::joint("one", "continuous", "a", "b", kAxis) +
            test::joint("two", "continuous", "a", "c", kAxis) + "</robot>")),
        "a", tip);
  };
  EXPECT_TRUE(std::holds_alternative<Chain>(arm("1", "1", "b")));
  EXPECT_EQ(why(arm("-1", "1", "b")), "its mass -1.000000 is negative");
  EXPECT_EQ(why(arm("1", "-1", "b")), "a moment of inertia is negative");
  EXPECT_TRUE(std::holds_alternative<Chain>(arm("-1", "-1", "c")));
}

TEST(Chain, AJointThatMimicsMovesWithItsLeader) {
  const auto robot =
      three_joints(kAxis, kAxis + kLimit + "<mimic joint='three' multiplier='-2' offset='0.1'/>");
  const auto free = three_joints(kAxis, kAxis + kLimit);
  const Chain chain = std::get<Chain>(make_chain(robot, "a", "d"));
  const Chain peer = std::get<Chain>(make_chain(free, "a", "d"));
  EXPECT_EQ(chain.joint_names, (std::vector<std::string>{"one", "three"}));
  const double q[] = {0.7, -0.2};
  const double moving[] = {0.7, 0.5, -0.2};
  Kinematics ours, theirs;
  forward_kinematics(chain, q, ours);
  forward_kinematics(peer, moving, theirs);
  EXPECT_EQ(ours.T_base_tip.position, theirs.T_base_tip.position);
  EXPECT_EQ(ours.jacobian[0], theirs.jacobian[0]);
  EXPECT_EQ(ours.jacobian[1], theirs.jacobian[2] - 2.0 * theirs.jacobian[1]);
}

TEST(Chain, AJointThatMimicsNarrowsTheLimitsOfItsLeader) {
  const Chain chain = std::get<Chain>(make_chain(
      three_joints(kAxis, kAxis + kLimit + "<mimic joint='three' multiplier='-2' offset='0.1'/>"),
      "a", "d"));
  EXPECT_DOUBLE_EQ(chain.lower[1], -0.2);
  EXPECT_DOUBLE_EQ(chain.upper[1], 0.55);
  EXPECT_DOUBLE_EQ(chain.velocity[1], 1.5);
  EXPECT_TRUE(chain.periodic[0]);
  EXPECT_FALSE(chain.periodic[1]);  // the joint after it slides
}

TEST(Chain, RefusesAMimicOfAJointOutsideTheArm) {
  const auto robot = three_joints(kAxis, kAxis + kLimit, kAxis + "<mimic joint='one'/>");
  EXPECT_EQ(why(make_chain(robot, "b", "d")),
            "mimics 'one', which is no joint of the arm; lock that one at a value");
  const auto held = std::get<urdf::Robot>(urdf::hold(robot, {{"one", 0.4}}));
  EXPECT_EQ(std::get<Chain>(make_chain(held, "b", "d")).joints(), 1);
}

TEST(Chain, AHeldJointStandsWhereItIsHeld) {
  const auto robot = three_joints(kAxis, kAxis + kLimit);
  const auto held = std::get<urdf::Robot>(urdf::hold(robot, {{"two", 0.3}}));
  const Chain whole = std::get<Chain>(make_chain(robot, "a", "d"));
  const Chain rest = std::get<Chain>(make_chain(held, "a", "d"));
  const double q[] = {0.7, -0.2};
  const double all[] = {0.7, 0.3, -0.2};
  EXPECT_LE((forward_kinematics(whole, all).position - forward_kinematics(rest, q).position).norm(),
            1e-15);
}

TEST(Chain, AToolMovesTheTip) {
  const Chain chain = std::get<Chain>(make_chain(crooked_robot(), "l0", "l9"));
  const Transform tool{Eigen::AngleAxisd(1.5, Eigen::Vector3d::UnitX()).toRotationMatrix(),
                       {0.1, 0.2, 0.3}};
  const JointVector q = JointVector::Constant(chain.joints(), 0.3);
  const Transform before = forward_kinematics(chain, q.data());
  const Transform after = forward_kinematics(with_tool(chain, tool), q.data());
  EXPECT_LE((after.position - before.position - before.rotation * tool.position).norm(), 1e-15);
  EXPECT_LE((after.rotation - before.rotation * tool.rotation).norm(), 1e-15);
}

TEST(Chain, BoundsLeaveAValue) {
  const Chain chain = std::get<Chain>(make_chain(crooked_robot(), "l0", "l9"));
  const double inf = std::numeric_limits<double>::infinity();
  Eigen::VectorXd lower = Eigen::VectorXd::Constant(chain.joints(), -1.0);
  const Eigen::VectorXd upper = -lower;
  EXPECT_EQ(with_bounds(chain, lower, upper).lower[0], -1.0);
  EXPECT_THROW(with_bounds(chain, lower.head(1), upper), std::invalid_argument);
  for (const double wrong : {1.5, inf, std::nan("")}) {
    lower[0] = wrong;
    EXPECT_THROW(with_bounds(chain, lower, upper), std::invalid_argument);
    EXPECT_THROW(with_bounds(chain, -upper, -lower), std::invalid_argument);
  }
}

}  // namespace leadthrough::chain_tests
