#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "leadthrough/arm/rigid.hpp"
#include "leadthrough/arm/urdf_parts.hpp"

namespace leadthrough::urdf {

namespace {

// Tolerance of values outside the limits by rounding, rad or m.
constexpr double kRounding = 1e-9;

std::string quoted(const std::string& name) { return "'" + name + "'"; }

bool slides_or_turns(const Joint& joint) {
  return joint.type == JointType::kRevolute || joint.type == JointType::kContinuous ||
         joint.type == JointType::kPrismatic;
}

// Fixes a joint at `value`.
void freeze(Joint& joint, double value) {
  Transform motion;
  if (joint.type == JointType::kPrismatic)
    motion.position = value * joint.axis;
  else if (joint.type != JointType::kFixed)
    motion.rotation = Eigen::AngleAxisd(value, joint.axis).toRotationMatrix();
  joint.T_parent_child = joint.T_parent_child * motion;
  joint.type = JointType::kFixed;
  joint.lower = joint.upper = 0.0;
  joint.mimic.reset();
}

std::string where(const Joint& joint) { return "joint " + quoted(joint.name); }

using Index = std::map<std::string, std::size_t>;

Index index_by_name(const Robot& robot) {
  Index index;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) index[robot.joints[i].name] = i;
  return index;
}

// Sets the mimics on the chain of references from joint `first` to its leader, from the leader on.
// `walks` holds for every joint the walk that visited it, 0 for none.
std::optional<Error> resolve(Robot& robot, const Index& index, std::size_t first,
                             std::vector<std::size_t>& walks) {
  const std::size_t walk = first + 1;
  std::vector<std::size_t> path;
  std::size_t at = first;
  while (walks[at] == 0 && robot.joints[at].mimic) {
    walks[at] = walk;
    path.push_back(at);
    at = index.at(robot.joints[at].mimic->joint);
  }
  if (walks[at] == walk)
    return Error{where(robot.joints[at]), "mimics itself, directly or by way of others"};
  for (auto i = path.rbegin(); i != path.rend(); ++i) {
    Mimic& mimic = *robot.joints[*i].mimic;
    const auto& leader = robot.joints[index.at(mimic.joint)].mimic;
    if (!leader) continue;
    mimic = {leader->joint, mimic.multiplier * leader->multiplier,
             mimic.multiplier * leader->offset + mimic.offset};
    if (!std::isfinite(mimic.multiplier) || !std::isfinite(mimic.offset))
      return Error{where(robot.joints[*i]), "its multiplier or offset is too large"};
  }
  return std::nullopt;
}

std::optional<Error> check_held(const Robot& robot, const Index& index, const Held& held) {
  const auto at = index.find(held.joint);
  const std::string name = "joint " + quoted(held.joint);
  if (at == index.end()) return Error{name, "does not exist"};
  const Joint& joint = robot.joints[at->second];
  if (joint.mimic) return Error{name, "mimics " + quoted(joint.mimic->joint) + "; lock that one"};
  if (!slides_or_turns(joint))
    return Error{name, joint.type == JointType::kFixed
                           ? "is fixed"
                           : "planar and floating joints cannot be locked"};
  return std::nullopt;
}

std::optional<Error> freeze_inside(Joint& joint, double value) {
  if (!(value >= joint.lower - kRounding && value <= joint.upper + kRounding))
    return Error{where(joint), std::to_string(value) + " is outside its limits " +
                                   std::to_string(joint.lower) + " to " +
                                   std::to_string(joint.upper)};
  freeze(joint, value);
  return std::nullopt;
}

}  // namespace

std::optional<Error> resolve_mimics(Robot& robot) {
  const Index index = index_by_name(robot);
  std::vector<std::size_t> walks(robot.joints.size(), 0);
  for (std::size_t i = 0; i < robot.joints.size(); ++i)
    if (auto error = resolve(robot, index, i, walks)) return error;
  for (Joint& joint : robot.joints) {
    if (!joint.mimic) continue;
    const bool led = robot.joints[index.at(joint.mimic->joint)].type != JointType::kFixed;
    if (led && joint.mimic->multiplier != 0.0) continue;
    if (auto error = freeze_inside(joint, joint.mimic->offset)) return error;
  }
  return std::nullopt;
}

std::variant<Robot, Error> hold(const Robot& robot, const std::vector<Held>& joints) {
  Robot result = robot;
  const Index index = index_by_name(robot);
  std::map<std::string, double> values;
  for (const Held& held : joints) {
    if (auto error = check_held(robot, index, held)) return *error;
    if (auto error = freeze_inside(result.joints[index.at(held.joint)], held.value)) return *error;
    values[held.joint] = held.value;
  }
  for (Joint& joint : result.joints) {
    const auto led = joint.mimic ? values.find(joint.mimic->joint) : values.end();
    if (led == values.end()) continue;
    const double value = joint.mimic->multiplier * led->second + joint.mimic->offset;
    if (auto error = freeze_inside(joint, value)) return *error;
  }
  return result;
}

}  // namespace leadthrough::urdf
