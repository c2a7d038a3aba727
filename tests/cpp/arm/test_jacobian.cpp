#include <gtest/gtest.h>

#include <kdl/chainjnttojacdotsolver.hpp>
#include <random>

#include "arm/kdl_chain.hpp"
#include "arm/robots.hpp"
#include "leadthrough/arm/frame_kinematics.hpp"
#include "leadthrough/arm/jacobian.hpp"

namespace leadthrough::jacobian_tests {

namespace {

Rows random_rows(Eigen::Index rows, Eigen::Index cols, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-3.0, 3.0);
  return Rows::NullaryExpr(rows, cols, [&] { return uniform(generator); });
}

}  // namespace

TEST(Jacobian, DerivativeAgreesWithKdl) {
  const urdf::Robot robot = std::get<urdf::Robot>(urdf::parse(test::crooked_arm()));
  const Chain chain = std::get<Chain>(make_chain(robot, "l0", "l9"));
  const KDL::Chain peer = test::kdl_chain(robot, "l0", "l9");
  KDL::ChainJntToJacDotSolver solver(peer);  // its default is our frame and point
  const Rows q = random_rows(100, chain.joints(), 1);
  const Rows qd = random_rows(100, chain.joints(), 2);
  for (Eigen::Index row = 0; row < q.rows(); ++row) {
    KDL::JntArrayVel motion(peer.getNrOfJoints());
    motion.q.data = q.row(row);
    motion.qdot.data = qd.row(row);
    KDL::Jacobian expected(peer.getNrOfJoints());
    ASSERT_EQ(solver.JntToJacDot(motion, expected), 0);
    JacobianColumns derivative;
    jacobian_derivative(chain, q.row(row).data(), qd.row(row).data(), derivative);
    for (Eigen::Index i = 0; i < chain.joints(); ++i)
      EXPECT_LE((derivative[static_cast<std::size_t>(i)] - expected.data.col(i)).norm(), 1e-12);
  }
}

TEST(Jacobian, FramesAndColumnsAgreeWhereJointsMimic) {
  std::string text = test::crooked_arm();
  text.insert(text.find("</joint>", text.find("'j4'")), "<mimic joint='j2' multiplier='-1.5'/>");
  text.insert(text.find("</joint>", text.find("'lift'")), "<mimic joint='j5' multiplier='0.1'/>");
  const urdf::Robot robot = std::get<urdf::Robot>(urdf::parse(text));
  const Chain chain = std::get<Chain>(make_chain(robot, "l0", "l9"));
  ASSERT_EQ(chain.joints(), 5);
  const Rows q = random_rows(1, 5, 6), qd = random_rows(1, 5, 7);
  BodyMotions bodies;
  body_motions(chain, q.data(), qd.data(), bodies);
  const FrameJacobian frame = frame_jacobian(chain, bodies, tip_frame(chain));
  Kinematics kinematics;
  forward_kinematics(chain, q.data(), kinematics);
  JacobianColumns derivative;
  jacobian_derivative(chain, q.data(), qd.data(), derivative);
  Vector6 rest = Vector6::Zero();  // J' qd
  for (int i = 0; i < 5; ++i) {
    EXPECT_LE((frame.col(i) - kinematics.jacobian[static_cast<std::size_t>(i)]).norm(), 1e-13);
    rest += qd(0, i) * derivative[static_cast<std::size_t>(i)];
  }
  const BodyMotion tip = frame_motion(bodies, tip_frame(chain));
  EXPECT_LE((tip.position - kinematics.T_base_tip.position).norm(), 1e-14);
  EXPECT_LE((tip.acceleration - rest.head<3>()).norm(), 1e-12);
  EXPECT_LE((tip.angular_acceleration - rest.tail<3>()).norm(), 1e-12);
}

TEST(Jacobian, BatchesHoldTheMatricesByRows) {
  const urdf::Robot robot = std::get<urdf::Robot>(urdf::parse(test::crooked_arm()));
  const Chain chain = std::get<Chain>(make_chain(robot, "l0", "l9"));
  const Rows q = random_rows(3, chain.joints(), 3);
  const Rows qd = random_rows(3, chain.joints(), 4);
  const Rows qdd = random_rows(3, chain.joints(), 5);
  const Rows batch = jacobian_second_derivative_batch(chain, q, qd, qdd);
  ASSERT_EQ(batch.cols(), 6 * chain.joints());
  JacobianColumns last;
  jacobian_second_derivative(chain, q.row(2).data(), qd.row(2).data(), qdd.row(2).data(), last);
  for (int row = 0; row < 6; ++row)
    for (int i = 0; i < chain.joints(); ++i)
      EXPECT_EQ(batch(2, row * chain.joints() + i), last[static_cast<std::size_t>(i)][row]);
}

}  // namespace leadthrough::jacobian_tests
