#pragma once

// Robot descriptions: URDF read by urdfdom, checked before (structure, bounds, numbers) and after
// (values), since urdfdom accepts contradictory robots and overflows its stack on deep trees.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "leadthrough/base/transform.hpp"

namespace leadthrough::urdf {

enum class JointType { kFixed, kRevolute, kContinuous, kPrismatic, kPlanar, kFloating };

struct Mimic {
  std::string joint;
  double multiplier = 1.0;
  double offset = 0.0;  // rad or m
};

// Angles in rad, lengths in m; absent limits are infinite.
struct Joint {
  std::string name;
  JointType type = JointType::kFixed;
  int parent = 0;  // links
  int child = 0;
  Transform T_parent_child;                         // at zero
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  // unit, in the child's frame
  double lower = 0.0;
  double upper = 0.0;
  double velocity = 0.0;
  double effort = 0.0;
  double friction = 0.0;       // N m or N
  double damping = 0.0;        // N m s/rad or N s/m
  std::optional<Mimic> mimic;  // of a joint that mimics none
};

struct Inertia {
  double mass = 0.0;                                  // kg
  Eigen::Vector3d center = Eigen::Vector3d::Zero();   // m, in the link's frame
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();  // kg m^2 about the centre, link's axes
};

enum class GeometryType { kBox, kCylinder, kCapsule, kSphere, kMesh };

// A piece of a link's geometry; cylinders and capsules lie along their own z.
struct Geometry {
  GeometryType type = GeometryType::kBox;
  Transform T_link_shape;
  Eigen::Vector3d angles = Eigen::Vector3d::Zero();  // roll, pitch and yaw of T_link_shape, rad
  Eigen::Vector3d size = Eigen::Vector3d::Ones();    // a box's edges, m; a mesh's scale
  double radius = 0.0;                               // m
  double length = 0.0;                    // m; of a capsule, between the centres of its end balls
  std::string file;                       // of a mesh, as written
  std::optional<Eigen::Vector3d> colour;  // red, green, blue in [0, 1], of a visual
};

struct Link {
  std::string name;
  int parent_joint = -1;  // -1 for the root
  Inertia inertia;
  std::vector<Geometry> collisions;
  std::vector<Geometry> visuals;  // sizes as written
};

// A tree. links[0] is the root; the parent link of a joint precedes its child.
struct Robot {
  std::string name;
  std::vector<Link> links;
  std::vector<Joint> joints;
};

struct Error {
  std::string where;  // the element at fault
  std::string why;
};

// More links than any robot has, and few enough for urdfdom's recursive destruction.
constexpr std::size_t kMaxLinks = 5000;

// The robot of a URDF document. By URDF's rules: if one of lower and upper is absent it is zero,
// axes of any nonzero length are normalised, continuous joints have no bounds; a joint that mimics
// a fixed joint is fixed.
std::variant<Robot, Error> parse(const std::string& document);

// Index of a link, or -1.
int find_link(const Robot& robot, const std::string& name);

struct Held {
  std::string joint;
  double value = 0.0;  // rad or m
};

// The robot with these joints fixed at their values, together with the joints that mimic them.
// Errors: joints that do not exist, are fixed or mimic, values outside the limits.
std::variant<Robot, Error> hold(const Robot& robot, const std::vector<Held>& joints);

}  // namespace leadthrough::urdf
