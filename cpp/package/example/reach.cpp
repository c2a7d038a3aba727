// Moves an arm's tip 5 cm up from the middle of its joints' ranges, past a ball:
//
//     reach panda.urdf panda_link0 panda_link8

#include <fstream>
#include <iostream>
#include <iterator>
#include <leadthrough/arm.hpp>
#include <stdexcept>
#include <string>

int main(int count, char** words) try {
  if (count != 4) {
    std::cerr << "usage: reach URDF BASE_LINK TIP_LINK\n";
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
  return report.first ? 1 : 0;
} catch (const std::invalid_argument& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
