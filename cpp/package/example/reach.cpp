// Moves an arm's tip 5 cm up from the middle of its joints' ranges:
//
//     reach panda.urdf panda_link0 panda_link8

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <leadthrough/arm/chain.hpp>
#include <leadthrough/ik/solve.hpp>
#include <string>
#include <utility>
#include <variant>

namespace {

[[noreturn]] void refuse(const leadthrough::urdf::Error& error) {
  std::cerr << error.where << ": " << error.why << '\n';
  std::exit(1);
}

template <typename Result>
Result accepted(std::variant<Result, leadthrough::urdf::Error> made) {
  if (const auto* error = std::get_if<leadthrough::urdf::Error>(&made)) refuse(*error);
  return std::get<Result>(std::move(made));
}

}  // namespace

int main(int count, char** words) {
  if (count != 4) {
    std::cerr << "usage: reach URDF BASE_LINK TIP_LINK\n";
    return 2;
  }
  std::ifstream file(words[1]);
  const std::string document(std::istreambuf_iterator<char>(file), {});
  const auto robot = accepted(leadthrough::urdf::parse(document));
  const auto chain = accepted(leadthrough::make_chain(robot, words[2], words[3]));

  const leadthrough::JointVector q0 = leadthrough::middle(chain);
  const leadthrough::Pose tip = leadthrough::forward_kinematics(chain, q0.data());
  const leadthrough::IkTarget target{tip.position + Eigen::Vector3d(0.0, 0.0, 0.05), tip.rotation};
  const leadthrough::IkResult result = leadthrough::solve_ik(chain, target, q0);
  std::cout << result.q.transpose() << '\n';
  return result.status == leadthrough::IkStatus::kConverged ? 0 : 1;
}
