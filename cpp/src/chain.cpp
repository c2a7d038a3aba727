#include "leadthrough/chain.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <kdl/chain.hpp>
#include <stdexcept>

#include "leadthrough/so3.hpp"
#include "run_down.hpp"

namespace leadthrough {

namespace {

using urdf::Joint;
using urdf::JointType;
using urdf::Robot;
using urdf::Transform;

Transform compose(const Transform& a, const Transform& b) {
  return {a.rotation * b.rotation, a.rotation * b.position + a.position};
}

// The shortest rotation that takes z to `axis`.
Eigen::Matrix3d turn_z_to(const Eigen::Vector3d& axis) {
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis).toRotationMatrix();
}

int find_link(const Robot& robot, const std::string& name) {
  for (std::size_t i = 0; i < robot.links.size(); ++i)
    if (robot.links[i].name == name) return static_cast<int>(i);
  return -1;
}

std::variant<std::vector<const Joint*>, urdf::Error> joints_between(const Robot& robot,
                                                                    const std::string& base,
                                                                    const std::string& tip) {
  const int first = find_link(robot, base);
  const int last = find_link(robot, tip);
  if (first < 0) return urdf::Error{"base", "no link is named '" + base + "'"};
  if (last < 0) return urdf::Error{"tip", "no link is named '" + tip + "'"};
  std::vector<const Joint*> joints;
  for (int link = last; link != first;) {
    const int index = robot.links[static_cast<std::size_t>(link)].parent_joint;
    if (index < 0) return urdf::Error{"tip", "'" + tip + "' does not hang from '" + base + "'"};
    joints.push_back(&robot.joints[static_cast<std::size_t>(index)]);
    link = joints.back()->parent;
  }
  std::reverse(joints.begin(), joints.end());
  return joints;
}

std::optional<urdf::Error> check_chain(const std::vector<const Joint*>& joints) {
  int moving = 0;
  for (const Joint* joint : joints) {
    const std::string where = "joint '" + joint->name + "'";
    if (joint->type == JointType::kPlanar || joint->type == JointType::kFloating)
      return urdf::Error{where, "planar and floating joints cannot be part of an arm"};
    if (joint->mimic) return urdf::Error{where, "a joint that mimics cannot be part of an arm"};
    if (joint->type != JointType::kFixed) ++moving;
  }
  if (moving == 0) return urdf::Error{"tip", "no joint moves between base and tip"};
  if (moving > kMaxJoints)
    return urdf::Error{"tip", std::to_string(moving) +
                                  " joints move between base and tip; at most " +
                                  std::to_string(kMaxJoints) + " are supported"};
  return std::nullopt;
}

Chain flatten(const std::vector<const Joint*>& joints) {
  Chain chain;
  Transform pending;
  for (const Joint* joint : joints) {
    pending = compose(pending, joint->T_parent_child);
    if (joint->type == JointType::kFixed) continue;
    const auto i = static_cast<std::size_t>(chain.joints());
    const Eigen::Matrix3d turn = turn_z_to(joint->axis);
    chain.fixed[i] = compose(pending, {turn, Eigen::Vector3d::Zero()});
    chain.prismatic[i] = joint->type == JointType::kPrismatic;
    chain.joint_names.push_back(joint->name);
    pending = {turn.transpose(), Eigen::Vector3d::Zero()};
  }
  chain.fixed[static_cast<std::size_t>(chain.joints())] = pending;
  return chain;
}

void take_limits(const std::vector<const Joint*>& joints, Chain& chain) {
  for (JointVector* limit : {&chain.lower, &chain.upper, &chain.velocity, &chain.effort})
    limit->resize(chain.joints());
  Eigen::Index i = 0;
  for (const Joint* joint : joints) {
    if (joint->type == JointType::kFixed) continue;
    chain.lower[i] = joint->lower;
    chain.upper[i] = joint->upper;
    chain.velocity[i] = joint->velocity;
    chain.effort[i] = joint->effort;
    ++i;
  }
}

KDL::Frame to_kdl(const Transform& transform) {
  const auto& r = transform.rotation;
  const auto& p = transform.position;
  return {KDL::Rotation(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1),
                        r(2, 2)),
          KDL::Vector(p[0], p[1], p[2])};
}

KDL::Joint to_kdl_joint(const Joint& joint) {
  if (joint.type == JointType::kFixed) return KDL::Joint(joint.name, KDL::Joint::Fixed);
  const Eigen::Vector3d axis = joint.T_parent_child.rotation * joint.axis;
  const auto& origin = joint.T_parent_child.position;
  return KDL::Joint(
      joint.name, KDL::Vector(origin[0], origin[1], origin[2]),
      KDL::Vector(axis[0], axis[1], axis[2]),
      joint.type == JointType::kPrismatic ? KDL::Joint::TransAxis : KDL::Joint::RotAxis);
}

KDL::RigidBodyInertia to_kdl(const urdf::Inertia& inertia) {
  const auto& m = inertia.moments;
  return KDL::RigidBodyInertia(
      inertia.mass, KDL::Vector(inertia.center[0], inertia.center[1], inertia.center[2]),
      KDL::RotationalInertia(m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)));
}

}  // namespace

std::variant<Chain, urdf::Error> make_chain(const Robot& robot, const std::string& base,
                                            const std::string& tip) {
  auto found = joints_between(robot, base, tip);
  if (const auto* error = std::get_if<urdf::Error>(&found)) return *error;
  const auto& joints = std::get<std::vector<const Joint*>>(found);
  if (auto error = check_chain(joints)) return *error;
  Chain chain = flatten(joints);
  take_limits(joints, chain);
  return chain;
}

KDL::Chain make_kdl_chain(const Robot& robot, const std::string& base, const std::string& tip) {
  const auto found = joints_between(robot, base, tip);
  const auto* error = std::get_if<urdf::Error>(&found);
  if (error != nullptr) throw std::invalid_argument(error->where + ": " + error->why);
  KDL::Chain chain;
  for (const Joint* joint : std::get<std::vector<const Joint*>>(found)) {
    const urdf::Link& link = robot.links[static_cast<std::size_t>(joint->child)];
    chain.addSegment(KDL::Segment(link.name, to_kdl_joint(*joint), to_kdl(joint->T_parent_child),
                                  to_kdl(link.inertia)));
  }
  return chain;
}

Pose forward_kinematics(const Chain& chain, const double* q) {
  return run_down(chain, q, [](std::size_t, const auto&, const auto&) {});
}

void forward_kinematics(const Chain& chain, const double* q, Kinematics& kinematics) {
  // Each column first holds its joint's origin and axis, until the tip's place is known.
  kinematics.T_base_tip =
      run_down(chain, q, [&](std::size_t i, const auto& axis, const auto& origin) {
        kinematics.jacobian[i].template head<3>() = origin;
        kinematics.jacobian[i].template tail<3>() = axis;
      });
  const auto n = static_cast<std::size_t>(chain.joints());
  for (std::size_t i = 0; i < n; ++i) {
    Vector6& column = kinematics.jacobian[i];
    const Eigen::Vector3d axis = column.tail<3>();
    if (chain.prismatic[i])
      column << axis, Eigen::Vector3d::Zero();
    else
      column.head<3>() = axis.cross(kinematics.T_base_tip.position - column.head<3>()).eval();
  }
}

Poses forward_kinematics_batch(const Chain& chain, const Eigen::Ref<const Rows>& q) {
  Poses poses{Rows3(q.rows(), 3), Rows4(q.rows(), 4)};
  for (Eigen::Index i = 0; i < q.rows(); ++i) {
    const Pose pose = forward_kinematics(chain, q.row(i).data());
    poses.positions.row(i) = pose.position;
    poses.orientations.row(i) = so3::from_matrix(pose.rotation);
  }
  return poses;
}

}  // namespace leadthrough
