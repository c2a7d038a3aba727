#include <gtest/gtest.h>

#include "arm/robots.hpp"
#include "leadthrough/arm.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace leadthrough::arm_tests {

TEST(Arm, AnswersAsTheFoldersDo) {
  const Arm arm(test::crooked_arm(), "l0", "l9");
  const Chain& chain = arm.chain();
  const JointVector q0 = middle(chain), rest = JointVector::Zero(chain.joints());
  EXPECT_TRUE(arm.within_limits(q0));
  const Transform tip = arm.forward_kinematics(q0);
  EXPECT_EQ(tip.position, forward_kinematics(chain, q0.data()).position);

  const Eigen::MatrixXd jacobian = arm.jacobian(q0);
  for (int k = 0; k < chain.joints(); ++k) {
    constexpr double kStep = 1e-6;
    JointVector q = q0;
    q[k] += kStep;
    const Eigen::Vector3d moved = arm.forward_kinematics(q).position - tip.position;
    EXPECT_LT((moved / kStep - jacobian.col(k).head<3>()).norm(), 1e-5);
  }
  // The torque of an acceleration is a column of the mass matrix.
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  const Eigen::VectorXd torques = arm.inverse_dynamics(q0, rest, JointVector::Unit(7, 2), none);
  EXPECT_LT((torques - arm.mass_matrix(q0).col(2)).norm(), 1e-9);

  const Rows3 positions = tip.position.transpose().replicate(3, 1);
  const Rows4 orientations = so3::from_matrix(tip.rotation).transpose().replicate(3, 1);
  EXPECT_EQ(arm.follow(positions, orientations, q0).q.rows(), 3);
  EXPECT_EQ(arm.check_itself(Rows::Zero(2, 7)).samples.size(), 2U);
}

TEST(Arm, SaysWhatIsWrong) {
  EXPECT_THROW(Arm("<robot/>", "l0", "l9"), std::invalid_argument);
  EXPECT_THROW(Arm(test::crooked_arm(), "l0", "nowhere"), std::invalid_argument);
  const Arm arm(test::crooked_arm(), "l0", "l9");
  const JointVector three = JointVector::Zero(3), seven = JointVector::Zero(7);
  EXPECT_THROW(arm.forward_kinematics(three), std::invalid_argument);
  EXPECT_THROW(arm.jacobian(three), std::invalid_argument);
  EXPECT_THROW(arm.inverse_dynamics(seven, three, seven), std::invalid_argument);
  EXPECT_THROW(arm.inverse_kinematics({{0.3, 0.0, 0.3}, {}}, three), std::invalid_argument);
  EXPECT_THROW(arm.follow(Rows3::Zero(2, 3), Rows4(1, 4), seven), std::invalid_argument);
  EXPECT_THROW(arm.check(Rows::Zero(2, 3), {}), std::invalid_argument);
}

}  // namespace leadthrough::arm_tests
