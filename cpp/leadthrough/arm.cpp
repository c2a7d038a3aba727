#include "leadthrough/arm.hpp"

#include <stdexcept>
#include <utility>
#include <variant>

#include "leadthrough/arm/jacobian.hpp"

namespace leadthrough {

namespace {

template <typename Result>
Result accepted(std::variant<Result, urdf::Error> made) {
  if (const auto* error = std::get_if<urdf::Error>(&made))
    throw std::invalid_argument(error->where + ": " + error->why);
  return std::get<Result>(std::move(made));
}

// A matrix that a batch's only row holds by rows.
Eigen::MatrixXd matrix(const Rows& row, Eigen::Index rows) {
  return Eigen::Map<const Rows>(row.data(), rows, row.size() / rows);
}

}  // namespace

Arm::Arm(const std::string& document, const std::string& base, const std::string& tip,
         const std::vector<MeshParts>& meshes)
    : Arm(accepted(urdf::parse(document)), base, tip, meshes) {}

Arm::Arm(const urdf::Robot& robot, const std::string& base, const std::string& tip,
         const std::vector<MeshParts>& meshes)
    : chain_(accepted(make_chain(robot, base, tip))), dynamics_(chain_) {
  model_ = make_collision_model(robot, chain_, base, tip, meshes, {});
  itself_ = itself(model_);
}

bool Arm::within_limits(const Joints& q) const {
  check_rows(chain_, q.transpose());
  return (q.array() >= chain_.lower.array()).all() && (q.array() <= chain_.upper.array()).all();
}

Transform Arm::forward_kinematics(const Joints& q) const {
  check_rows(chain_, q.transpose());
  return leadthrough::forward_kinematics(chain_, q.data());
}

Eigen::MatrixXd Arm::jacobian(const Joints& q) const {
  return matrix(jacobian_batch(chain_, q.transpose()), 6);
}

Eigen::VectorXd Arm::inverse_dynamics(const Joints& q, const Joints& qd, const Joints& qdd,
                                      const Eigen::Vector3d& gravity) const {
  return dynamics_.torques(q.transpose(), qd.transpose(), qdd.transpose(), gravity).transpose();
}

Eigen::MatrixXd Arm::mass_matrix(const Joints& q) const {
  return matrix(dynamics_.mass_matrices(q.transpose()), chain_.joints());
}

IkResult Arm::inverse_kinematics(const IkTarget& target, const Joints& q0,
                                 const IkOptions& options) const {
  return solve_ik(chain_, target, q0, options);
}

Track Arm::follow(const Rows3Ref& positions, const Rows4Ref& orientations, const Joints& q0,
                  const TrackOptions& options) const {
  const Rows none = Rows::Constant(positions.rows(), chain_.joints(), kInfinity);
  const Eigen::VectorXd shares = Eigen::VectorXd::Zero(positions.rows());
  return track(chain_, positions, orientations, q0, {none, shares}, options);
}

MotionReport Arm::check_itself(const Path& q, const MotionOptions& options) const {
  return check_motion(itself_, q, options);
}

MotionReport Arm::check(const Path& q, const std::vector<Shape>& obstacles,
                        const MotionOptions& options) const {
  return check_motion(against(model_, placed_shapes(obstacles)), q, options);
}

}  // namespace leadthrough
