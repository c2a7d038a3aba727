#include <gtest/gtest.h>

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <random>

#include "leadthrough/chain.hpp"
#include "robots.hpp"

using namespace leadthrough;

namespace {

urdf::Robot crooked_robot() { return std::get<urdf::Robot>(urdf::parse(test::crooked_arm())); }

std::string why(const std::variant<Chain, urdf::Error>& answer) {
  return std::get<urdf::Error>(answer).why;
}

}  // namespace

TEST(Chain, KinematicsAgreeWithKdl) {
  const urdf::Robot robot = crooked_robot();
  const Chain chain = std::get<Chain>(make_chain(robot, "l0", "l9"));
  const KDL::Chain peer = make_kdl_chain(robot, "l0", "l9");
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
  EXPECT_THROW(make_kdl_chain(robot, "l9", "l0"), std::invalid_argument);
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

TEST(Chain, RefusesJointsThatMimicOrFloat) {
  const auto build = [](const std::string& second) {
    return std::get<urdf::Robot>(urdf::parse(
        "<robot name='r'>" + test::link("a") + test::link("b") + test::link("c") +
        test::joint("one", "continuous", "a", "b", "<axis xyz='0 0 1'/>") + second + "</robot>"));
  };
  const auto mimic =
      build(test::joint("two", "continuous", "b", "c", "<axis xyz='0 0 1'/><mimic joint='one'/>"));
  EXPECT_EQ(why(make_chain(mimic, "a", "c")), "a joint that mimics cannot be part of an arm");
  const auto floating = build(test::joint("two", "floating", "b", "c", ""));
  EXPECT_EQ(why(make_chain(floating, "a", "c")),
            "planar and floating joints cannot be part of an arm");
}
