#include "leadthrough/arm/urdf.hpp"

#include <urdf_parser/urdf_parser.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "leadthrough/arm/urdf_parts.hpp"
#include "leadthrough/base/constants.hpp"

namespace leadthrough::urdf {

namespace {

// Shorter axes are a mistake, not a direction with rounding.
constexpr double kMinAxisLength = 1e-6;

Transform to_transform(const ::urdf::Pose& pose) {
  const auto& r = pose.rotation;
  return {Eigen::Quaterniond(r.w, r.x, r.y, r.z).normalized().toRotationMatrix(),
          Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z)};
}

bool finite(const Transform& transform) {
  return transform.rotation.allFinite() && transform.position.allFinite();
}

std::optional<JointType> to_type(int type) {
  switch (type) {
    case ::urdf::Joint::FIXED:
      return JointType::kFixed;
    case ::urdf::Joint::REVOLUTE:
      return JointType::kRevolute;
    case ::urdf::Joint::CONTINUOUS:
      return JointType::kContinuous;
    case ::urdf::Joint::PRISMATIC:
      return JointType::kPrismatic;
    case ::urdf::Joint::PLANAR:
      return JointType::kPlanar;
    case ::urdf::Joint::FLOATING:
      return JointType::kFloating;
    default:
      return std::nullopt;
  }
}

bool has_axis(JointType type) { return type != JointType::kFixed && type != JointType::kFloating; }

bool has_bounds(JointType type) {
  return type == JointType::kRevolute || type == JointType::kPrismatic;
}

std::optional<Error> check_joint(const Joint& joint) {
  const std::string where = "joint '" + joint.name + "'";
  if (!finite(joint.T_parent_child)) return Error{where, "its origin is not finite"};
  if (!joint.axis.allFinite()) return Error{where, "its axis is zero or not finite"};
  if (!(joint.lower <= joint.upper))
    return Error{where, "its lower limit " + std::to_string(joint.lower) +
                            " is above its upper limit " + std::to_string(joint.upper)};
  if (!(joint.velocity >= 0.0)) return Error{where, "its velocity limit is negative"};
  if (!(joint.effort >= 0.0)) return Error{where, "its effort limit is negative"};
  if (!(joint.damping >= 0.0)) return Error{where, "its damping is negative"};
  if (!(joint.friction >= 0.0)) return Error{where, "its friction is negative"};
  return std::nullopt;
}

Joint to_joint(const ::urdf::Joint& source) {
  Joint joint;
  joint.name = source.name;
  joint.type = to_type(source.type).value_or(JointType::kFixed);
  joint.T_parent_child = to_transform(source.parent_to_joint_origin_transform);
  if (has_axis(joint.type)) {
    const Eigen::Vector3d axis(source.axis.x, source.axis.y, source.axis.z);
    const double length = axis.stableNorm();
    joint.axis = axis / (length < kMinAxisLength ? 0.0 : length);
  }
  const bool limited = source.limits != nullptr;
  joint.velocity = limited ? source.limits->velocity : kInfinity;
  joint.effort = limited ? source.limits->effort : kInfinity;
  const bool bounded = has_bounds(joint.type) && limited;
  joint.lower = bounded ? source.limits->lower : joint.type == JointType::kFixed ? 0.0 : -kInfinity;
  joint.upper = bounded ? source.limits->upper : joint.type == JointType::kFixed ? 0.0 : kInfinity;
  if (source.dynamics) {
    joint.friction = source.dynamics->friction;
    joint.damping = source.dynamics->damping;
  }
  if (source.mimic)
    joint.mimic = Mimic{source.mimic->joint_name, source.mimic->multiplier, source.mimic->offset};
  return joint;
}

Inertia to_inertia(const ::urdf::Inertial& source) {
  const Transform origin = to_transform(source.origin);
  Eigen::Matrix3d moments;
  moments << source.ixx, source.ixy, source.ixz,  //
      source.ixy, source.iyy, source.iyz,         //
      source.ixz, source.iyz, source.izz;
  return {source.mass, origin.position, origin.rotation * moments * origin.rotation.transpose()};
}

Link to_link(const ::urdf::Link& source) {
  Link link;
  link.name = source.name;
  if (source.inertial) link.inertia = to_inertia(*source.inertial);
  return link;
}

// Parents first, children by name. A loop, since a chain may be thousands of links long.
std::variant<Robot, Error> to_robot(const ::urdf::ModelInterface& model) {
  Robot robot;
  robot.name = model.getName();
  std::vector<::urdf::LinkConstSharedPtr> sources{model.getRoot()};
  robot.links.push_back(to_link(*sources.front()));
  for (std::size_t i = 0; i < sources.size(); ++i) {
    for (const auto& source : sources[i]->child_joints) {
      Joint joint = to_joint(*source);
      if (auto error = check_joint(joint)) return *error;
      joint.parent = static_cast<int>(i);
      joint.child = static_cast<int>(robot.links.size());
      sources.push_back(model.getLink(source->child_link_name));
      robot.links.push_back(to_link(*sources.back()));
      robot.links.back().parent_joint = static_cast<int>(robot.joints.size());
      robot.joints.push_back(std::move(joint));
    }
  }
  if (auto error = resolve_mimics(robot)) return *error;
  return robot;
}

}  // namespace

std::variant<Robot, Error> parse(const std::string& document) {
  const auto scanned = xml::scan(document);
  if (const auto* error = std::get_if<xml::Error>(&scanned)) return Error{error->where, error->why};
  const auto& elements = std::get<xml::Elements>(scanned);
  if (auto error = check_structure(elements)) return *error;
  try {
    auto geometry = read_geometry(elements);
    if (const auto* error = std::get_if<Error>(&geometry)) return *error;
    const ::urdf::ModelInterfaceSharedPtr model = ::urdf::parseURDF(without_capsules(document));
    if (!model || !model->getRoot())
      return Error{"robot", "urdfdom cannot read it; its reason is on standard error"};
    auto robot = to_robot(*model);
    if (auto* read = std::get_if<Robot>(&robot))
      for (Link& link : read->links) {
        LinkGeometry& own = std::get<GeometryByLink>(geometry)[link.name];
        link.collisions = std::move(own.collisions);
        link.visuals = std::move(own.visuals);
      }
    return robot;
  } catch (const std::exception& error) {
    return Error{"robot", error.what()};
  }
}

int find_link(const Robot& robot, const std::string& name) {
  const auto named = [&](const Link& link) { return link.name == name; };
  const auto found = std::find_if(robot.links.begin(), robot.links.end(), named);
  return found == robot.links.end() ? -1 : static_cast<int>(found - robot.links.begin());
}

}  // namespace leadthrough::urdf
