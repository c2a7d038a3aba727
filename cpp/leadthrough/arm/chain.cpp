#include "leadthrough/arm/chain.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "leadthrough/arm/rigid.hpp"
#include "leadthrough/arm/run_down.hpp"
#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace leadthrough {

namespace {

using urdf::Joint;
using urdf::JointType;
using urdf::Robot;
using Joints = std::vector<const Joint*>;

std::string quoted(const std::string& name) { return "'" + name + "'"; }

// The shortest rotation that takes z to `axis`. Eigen's own function uses a singular value
// decomposition for angles of pi, which takes longer to compile than the rest of this file.
Eigen::Matrix3d turn_z_to(const Eigen::Vector3d& axis) {
  constexpr double kHalfTurn = 1e-12;  // of the cosine
  const Eigen::Vector3d unit = axis.normalized();
  const Eigen::Vector3d across = Eigen::Vector3d::UnitZ().cross(unit);
  const double cosine = unit.z();
  Eigen::Quaterniond turn;
  if (cosine < kHalfTurn - 1.0) {
    const double half = 0.5 * (1.0 + std::max(cosine, -1.0));
    const bool exactly = across.isZero(0.0);
    turn.vec() =
        std::sqrt(1.0 - half) * (exactly ? Eigen::Vector3d::UnitX() : across.normalized().eval());
    turn.w() = std::sqrt(half);
  } else {
    const double twice_w = std::sqrt(2.0 * (1.0 + cosine));
    turn.vec() = across * (1.0 / twice_w);
    turn.w() = 0.5 * twice_w;
  }
  return turn.toRotationMatrix();
}

Joints moving_joints(const Joints& joints) {
  Joints moving;
  std::copy_if(joints.begin(), joints.end(), std::back_inserter(moving),
               [](const Joint* joint) { return joint->type != JointType::kFixed; });
  return moving;
}

// The joint that drives `joint`: itself, or the one that it mimics.
const std::string& driver(const Joint& joint) {
  return joint.mimic ? joint.mimic->joint : joint.name;
}

std::optional<urdf::Error> check_chain(const Joints& moving) {
  if (moving.empty()) return urdf::Error{"tip", "no joint moves between base and tip"};
  if (moving.size() > static_cast<std::size_t>(kMaxJoints))
    return urdf::Error{"tip", std::to_string(moving.size()) +
                                  " joints move between base and tip; at most " +
                                  std::to_string(kMaxJoints) + " are supported"};
  for (const Joint* joint : moving) {
    const std::string where = "joint " + quoted(joint->name);
    if (joint->type == JointType::kPlanar || joint->type == JointType::kFloating)
      return urdf::Error{where, "planar and floating joints cannot be part of an arm"};
    const bool driven = std::any_of(moving.begin(), moving.end(), [joint](const Joint* other) {
      return other->name == driver(*joint);
    });
    if (!driven)
      return urdf::Error{where, "mimics " + quoted(driver(*joint)) +
                                    ", which is no joint of the arm; lock that one at a value"};
  }
  return std::nullopt;
}

void flatten(const Joints& joints, Chain& chain) {
  Transform pending;
  for (const Joint* joint : joints) {
    pending = pending * joint->T_parent_child;
    if (joint->type == JointType::kFixed) continue;
    const auto k = moving_count(chain);
    const Eigen::Matrix3d turn = turn_z_to(joint->axis);
    chain.fixed[k] = pending * Transform{turn, Eigen::Vector3d::Zero()};
    chain.prismatic[k] = joint->type == JointType::kPrismatic;
    ++chain.moving;
    pending = {turn.transpose(), Eigen::Vector3d::Zero()};
  }
  chain.fixed[moving_count(chain)] = pending;
}

void set_drives(const Joints& moving, Chain& chain) {
  for (const Joint* joint : moving)
    if (!joint->mimic) chain.joint_names.push_back(joint->name);
  const auto& names = chain.joint_names;
  std::fill_n(chain.periodic.begin(), names.size(), true);
  for (std::size_t k = 0; k < moving.size(); ++k) {
    const auto index = std::find(names.begin(), names.end(), driver(*moving[k])) - names.begin();
    Drive& drive = chain.drives[k];
    drive.joint = static_cast<int>(index);
    if (moving[k]->mimic) {
      drive.multiplier = moving[k]->mimic->multiplier;
      drive.offset = moving[k]->mimic->offset;
      chain.mimics = true;
    }
    if (chain.prismatic[k] || std::trunc(drive.multiplier) != drive.multiplier)
      chain.periodic[static_cast<std::size_t>(index)] = false;
  }
}

std::optional<urdf::Error> narrow(const Joint& joint, const Drive& drive, Chain& chain) {
  double& lower = chain.lower[drive.joint];
  double& upper = chain.upper[drive.joint];
  double from = (joint.lower - drive.offset) / drive.multiplier;
  double to = (joint.upper - drive.offset) / drive.multiplier;
  if (drive.multiplier < 0.0) std::swap(from, to);
  lower = std::max(lower, from);
  upper = std::min(upper, to);
  chain.velocity[drive.joint] =
      std::min(chain.velocity[drive.joint], joint.velocity / std::abs(drive.multiplier));
  if (lower <= upper) return std::nullopt;
  return urdf::Error{
      "joint " + quoted(joint.name),
      "its limits and those of " + quoted(driver(joint)) + ", which it mimics, leave no value"};
}

std::optional<urdf::Error> take_limits(const Joints& moving, Chain& chain) {
  for (JointVector* limit : {&chain.lower, &chain.upper, &chain.velocity, &chain.effort})
    limit->resize(chain.joints());
  for (std::size_t k = 0; k < moving.size(); ++k) {
    if (moving[k]->mimic) continue;
    const int i = chain.drives[k].joint;
    chain.lower[i] = moving[k]->lower;
    chain.upper[i] = moving[k]->upper;
    chain.velocity[i] = moving[k]->velocity;
    chain.effort[i] = moving[k]->effort;
  }
  for (std::size_t k = 0; k < moving.size(); ++k)
    if (moving[k]->mimic)
      if (auto error = narrow(*moving[k], chain.drives[k], chain)) return error;
  return std::nullopt;
}

std::optional<urdf::Error> check_inertia(const urdf::Link& link) {
  const std::string where = "link " + quoted(link.name);
  const urdf::Inertia& inertia = link.inertia;
  if (!(inertia.mass >= 0.0))
    return urdf::Error{where, "its mass " + std::to_string(inertia.mass) + " is negative"};
  if ((inertia.moments.diagonal().array() < 0.0).any())
    return urdf::Error{where, "a moment of inertia is negative"};
  return std::nullopt;
}

// Adds every link to the body of the moving joint that it is fixed to, on any branch.
std::optional<urdf::Error> take_bodies(const Robot& robot, const Joints& moving, Chain& chain) {
  constexpr int kNoBody = -1;  // static, or moved by a joint outside the chain
  struct Mount {
    int body = kNoBody;
    Transform T_body_link;
  };
  std::vector<Mount> mounts(robot.links.size());
  for (const Joint& joint : robot.joints) {  // parents precede their children
    Mount& mount = mounts[static_cast<std::size_t>(joint.child)];
    const auto at = std::find(moving.begin(), moving.end(), &joint);
    if (at != moving.end())
      mount = {static_cast<int>(at - moving.begin()),
               {turn_z_to(joint.axis).transpose(), Eigen::Vector3d::Zero()}};
    else if (joint.type == JointType::kFixed) {
      const Mount& parent = mounts[static_cast<std::size_t>(joint.parent)];
      mount = {parent.body, parent.T_body_link * joint.T_parent_child};
    }
    if (mount.body == kNoBody) continue;
    const urdf::Link& link = robot.links[static_cast<std::size_t>(joint.child)];
    if (auto error = check_inertia(link)) return error;
    urdf::Inertia& body = chain.bodies[static_cast<std::size_t>(mount.body)];
    body = body + mount.T_body_link * link.inertia;
    chain.mass += link.inertia.mass;
  }
  return std::nullopt;
}

}  // namespace

std::variant<std::vector<const Joint*>, urdf::Error> joints_between(const Robot& robot,
                                                                    const std::string& base,
                                                                    const std::string& tip) {
  const int first = urdf::find_link(robot, base);
  const int last = urdf::find_link(robot, tip);
  if (first < 0) return urdf::Error{"base", "no link is named " + quoted(base)};
  if (last < 0) return urdf::Error{"tip", "no link is named " + quoted(tip)};
  Joints joints;
  for (int link = last; link != first;) {
    const int index = robot.links[static_cast<std::size_t>(link)].parent_joint;
    if (index < 0) return urdf::Error{"tip", quoted(tip) + " does not hang from " + quoted(base)};
    joints.push_back(&robot.joints[static_cast<std::size_t>(index)]);
    link = joints.back()->parent;
  }
  std::reverse(joints.begin(), joints.end());
  return joints;
}

std::variant<Chain, urdf::Error> make_chain(const Robot& robot, const std::string& base,
                                            const std::string& tip) {
  auto found = joints_between(robot, base, tip);
  if (const auto* error = std::get_if<urdf::Error>(&found)) return *error;
  const auto& joints = std::get<Joints>(found);
  const Joints moving = moving_joints(joints);
  if (auto error = check_chain(moving)) return *error;
  Chain chain;
  flatten(joints, chain);
  set_drives(moving, chain);
  if (auto error = take_limits(moving, chain)) return *error;
  if (auto error = take_bodies(robot, moving, chain)) return *error;
  return chain;
}

Chain with_bounds(const Chain& chain, const VectorRef& lower, const VectorRef& upper) {
  check_argument(lower.size() == chain.joints() && upper.size() == chain.joints(),
                 "bounds: expected one of each joint");
  check_argument(
      (lower.array() <= upper.array() && lower.array() < kInfinity && upper.array() > -kInfinity)
          .all(),
      "bounds: expected some value of each joint between lower and upper");
  Chain result = chain;
  result.lower = lower;
  result.upper = upper;
  return result;
}

Chain with_tool(const Chain& chain, const Transform& T_tip_tool) {
  Chain result = chain;
  Transform& T_body_tip = result.fixed[moving_count(chain)];
  T_body_tip = T_body_tip * T_tip_tool;
  return result;
}

Chain with_load(const Chain& chain, const urdf::Inertia& load) {
  Chain result = chain;
  const auto last = moving_count(chain) - 1;
  result.bodies[last] = result.bodies[last] + chain.fixed[last + 1] * load;
  return result;
}

JointRange sampled_range(const Chain& chain, int joint) {
  const double lower = chain.lower[joint], upper = chain.upper[joint];
  const bool from = std::isfinite(lower), to = std::isfinite(upper);
  const double reach = chain.periodic[static_cast<std::size_t>(joint)] ? kPi : 1.0;
  return {from ? lower
          : to ? upper - 2.0 * reach
               : -reach,
          to     ? upper
          : from ? lower + 2.0 * reach
                 : reach};
}

double reach(const Chain& chain) {
  double sum = 0.0;
  for (std::size_t k = 0; k < moving_count(chain); ++k) {
    sum += chain.fixed[k + 1].position.norm();
    if (!chain.prismatic[k]) continue;
    const Drive& drive = chain.drives[k];
    const double from = drive.multiplier * chain.lower[drive.joint] + drive.offset;
    const double to = drive.multiplier * chain.upper[drive.joint] + drive.offset;
    sum += std::max(std::abs(from), std::abs(to));
  }
  return sum;
}

Transform forward_kinematics(const Chain& chain, const double* q) {
  MovingValues room;
  return run_down(chain, moving_values(chain, q, room),
                  [](std::size_t, const auto&, const auto&) {});
}

void forward_kinematics(const Chain& chain, const double* q, Kinematics& kinematics) {
  MovingValues room;
  // Each column first holds its joint's origin and axis, until the tip's position is known.
  kinematics.T_base_tip = run_down(chain, moving_values(chain, q, room),
                                   [&](std::size_t k, const auto& axis, const auto& origin) {
                                     kinematics.jacobian[k].template head<3>() = origin;
                                     kinematics.jacobian[k].template tail<3>() = axis;
                                   });
  for (std::size_t k = 0; k < moving_count(chain); ++k) {
    Vector6& column = kinematics.jacobian[k];
    const Eigen::Vector3d axis = column.tail<3>();
    if (chain.prismatic[k])
      column << axis, Eigen::Vector3d::Zero();
    else
      column.head<3>() = axis.cross(kinematics.T_base_tip.position - column.head<3>()).eval();
  }
  gather(chain, kinematics.jacobian);
}

void check_rows(const Chain& chain, const RowsRef& q) {
  check_argument(q.cols() == chain.joints(), "rows of configurations: expected one value a joint");
}

void check_rates(const Chain& chain, const RowsRef& q, std::initializer_list<RowsRef> rates) {
  check_rows(chain, q);
  for (const auto& each : rates)
    check_argument(each.rows() == q.rows() && each.cols() == q.cols(),
                   "rates: expected the size of the configurations");
}

Poses forward_kinematics_batch(const Chain& chain, const RowsRef& q) {
  check_rows(chain, q);
  Poses poses{Rows3(q.rows(), 3), Rows4(q.rows(), 4)};
  for (Eigen::Index i = 0; i < q.rows(); ++i) {
    check_interrupt(i);
    const Transform pose = forward_kinematics(chain, q.row(i).data());
    poses.positions.row(i) = pose.position;
    poses.orientations.row(i) = so3::from_matrix(pose.rotation);
  }
  return poses;
}

}  // namespace leadthrough
