#include "leadthrough/simulation/joint_law.hpp"

#include <utility>

#include "leadthrough/base/argument.hpp"

namespace leadthrough::simulation {

JointLaw::JointLaw(const Dynamics& dynamics, const Eigen::Vector3d& gravity, Eigen::VectorXd rotors,
                   JointGains gains, Model model)
    : dynamics_(dynamics, gravity),
      rotors_(std::move(rotors)),
      still_(Eigen::VectorXd::Zero(rotors_.size())),
      wanted_(still_),
      torques_(still_),
      gains_(std::move(gains)),
      model_(model) {
  for (const Eigen::Index size : {rotors_.size(), gains_.springs.size(), gains_.dampers.size()})
    check_argument(size == dynamics.joints(), "gains: one value a joint");
}

const Eigen::VectorXd& JointLaw::torques(const Moment& now) {
  const auto away = now.target_q - now.q, slip = now.target_qd - now.qd;
  if (model_ == Model::motion) {
    wanted_ = now.qdd + gains_.damping * slip + gains_.stiffness * away;
    dynamics_.torques(now.q.data(), now.qd.data(), wanted_.data(), torques_.data());
    torques_ += rotors_.cwiseProduct(wanted_);
  } else if (model_ == Model::weight) {
    dynamics_.torques(now.q.data(), still_.data(), still_.data(), torques_.data());
  } else {
    torques_.setZero();
  }
  torques_ += gains_.springs.cwiseProduct(away) + gains_.dampers.cwiseProduct(slip);
  return torques_;
}

}  // namespace leadthrough::simulation
