#pragma once

// KDL's own chain of a robot without mimics, link by link: what ours is compared with.

#include <kdl/chain.hpp>

#include "leadthrough/arm/chain.hpp"

namespace leadthrough::test {

inline KDL::Frame to_kdl(const Transform& transform) {
  const auto& r = transform.rotation;
  const auto& p = transform.position;
  return {KDL::Rotation(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1),
                        r(2, 2)),
          KDL::Vector(p[0], p[1], p[2])};
}

inline KDL::Joint to_kdl(const urdf::Joint& joint) {
  if (joint.type == urdf::JointType::kFixed) return KDL::Joint(joint.name, KDL::Joint::Fixed);
  const Eigen::Vector3d axis = joint.T_parent_child.rotation * joint.axis;
  const auto& origin = joint.T_parent_child.position;
  return KDL::Joint(
      joint.name, KDL::Vector(origin[0], origin[1], origin[2]),
      KDL::Vector(axis[0], axis[1], axis[2]),
      joint.type == urdf::JointType::kPrismatic ? KDL::Joint::TransAxis : KDL::Joint::RotAxis);
}

inline KDL::RigidBodyInertia to_kdl(const urdf::Inertia& inertia) {
  const auto& m = inertia.moments;
  return KDL::RigidBodyInertia(
      inertia.mass, KDL::Vector(inertia.center[0], inertia.center[1], inertia.center[2]),
      KDL::RotationalInertia(m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)));
}

inline KDL::Chain kdl_chain(const urdf::Robot& robot, const std::string& base,
                            const std::string& tip) {
  KDL::Chain chain;
  const auto joints = joints_between(robot, base, tip);
  for (const urdf::Joint* joint : std::get<std::vector<const urdf::Joint*>>(joints)) {
    const urdf::Link& link = robot.links[static_cast<std::size_t>(joint->child)];
    chain.addSegment(KDL::Segment(link.name, to_kdl(*joint), to_kdl(joint->T_parent_child),
                                  to_kdl(link.inertia)));
  }
  return chain;
}

}  // namespace leadthrough::test
