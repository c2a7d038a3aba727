// Moves an arm's tip 5 cm up from the middle of its joints' ranges, past a ball, and runs a skill
// of its joints that Python exported, if one is given:
//
//     reach panda.urdf panda_link0 panda_link8 [skill.npz]

#include <fstream>
#include <iostream>
#include <iterator>
#include <leadthrough/arm.hpp>
#include <leadthrough/guard.hpp>
#include <leadthrough/skill.hpp>
#include <stdexcept>
#include <string>

// The commands of a skill of the arm's joints in 3 s, one a millisecond. The limits of acceleration
// and jerk are those of its maker.
bool run(const leadthrough::Arm& arm, leadthrough::Dmp skill) {
  constexpr double kPeriod = 0.001;  // s
  const leadthrough::Chain& chain = arm.chain();
  if (skill.joint_names() != chain.joint_names) return false;
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(chain.joints());
  leadthrough::Guard guard(
      arm, {chain.lower, chain.upper, chain.velocity, 7.5 * ones, 3750.0 * ones, kPeriod});

  skill.begin({}, {}, 3.0);
  guard.start(skill.position());
  leadthrough::Rows motion(3000, chain.joints());
  for (Eigen::Index i = 0; i < motion.rows(); ++i) {
    skill.step(kPeriod);
    motion.row(i) = skill.position();
  }
  if (!guard.admit(motion)) return false;
  while (guard.remaining() > 0) guard.next();  // every period, and guard.q() goes to the arm
  std::cout << skill.joint_names().front() << " at the end " << guard.q()[0] << '\n';
  return true;
}

int main(int count, char** words) try {
  if (count != 4 && count != 5) {
    std::cerr << "usage: reach URDF BASE_LINK TIP_LINK [SKILL]\n";
    return 2;
  }
  std::ifstream file(words[1]);
  const std::string document(std::istreambuf_iterator<char>(file), {});
  const leadthrough::Arm arm(document, words[2], words[3]);

  const leadthrough::JointVector q0 = leadthrough::middle(arm.chain());
  const leadthrough::Transform tip = arm.forward_kinematics(q0);
  const leadthrough::IkTarget target{tip.position + Eigen::Vector3d(0.0, 0.0, 0.05), tip.rotation};
  const leadthrough::IkResult result = arm.inverse_kinematics(target, q0);
  if (result.status != leadthrough::IkStatus::kConverged) return 1;

  leadthrough::Rows motion(2, q0.size());
  motion << q0.transpose(), result.q.transpose();
  const auto ball = leadthrough::primitive("sphere", Eigen::VectorXd::Constant(1, 0.1));
  const leadthrough::Shape obstacle{Eigen::Matrix3d::Identity(), {1.0, 1.0, 0.5}, *ball};
  const leadthrough::MotionReport report = arm.check(motion, {obstacle});
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(q0.size());
  std::cout << result.q.transpose() << '\n'
            << "clearance " << report.closest.nearest.distance << " m, torques "
            << arm.inverse_dynamics(result.q, still, still).transpose() << '\n';
  if (report.first) return 1;
  return count == 5 && !run(arm, leadthrough::Dmp(words[4])) ? 1 : 0;
} catch (const std::invalid_argument& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
