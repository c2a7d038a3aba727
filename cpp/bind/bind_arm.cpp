#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <array>
#include <map>
#include <tuple>

#include "bind/parts.hpp"
#include "leadthrough/arm/dynamics.hpp"
#include "leadthrough/arm/jacobian.hpp"
#include "leadthrough/arm/urdf.hpp"
#include "leadthrough/ik/solve.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

// A document's text may be cut inside a character.
py::str to_text(const std::string& text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "replace"));
}

template <typename... Arguments>
[[noreturn]] void raise(const char* name, const Arguments&... arguments) {
  const py::object type = py::module_::import("leadthrough.errors").attr(name);
  PyErr_SetObject(type.ptr(), type(arguments...).ptr());
  throw py::error_already_set();
}

template <typename Value>
Value value_or_raise(std::variant<Value, urdf::Error>&& answer) {
  if (const auto* error = std::get_if<urdf::Error>(&answer))
    raise("InvalidRobot", to_text(error->where), to_text(error->why));
  return std::get<Value>(std::move(answer));
}

urdf::Robot parse(const std::string& document) {
  return value_or_raise(without_gil([&] { return urdf::parse(document); }));
}

std::vector<urdf::Joint> path(const urdf::Robot& robot, const std::string& base,
                              const std::string& tip) {
  std::vector<urdf::Joint> joints;
  for (const urdf::Joint* joint : value_or_raise(joints_between(robot, base, tip)))
    joints.push_back(*joint);
  return joints;
}

// A value that a joint cannot be locked at is the caller's mistake and not the robot's.
urdf::Robot hold(const urdf::Robot& robot,
                 const std::vector<std::pair<std::string, double>>& values) {
  std::vector<urdf::Held> joints;
  for (const auto& [name, value] : values) joints.push_back({name, value});
  auto answer = urdf::hold(robot, joints);
  if (const auto* error = std::get_if<urdf::Error>(&answer))
    raise("InvalidInput", to_text("locked_joints: " + error->where + ": " + error->why));
  return std::get<urdf::Robot>(std::move(answer));
}

// Names of types, in the order of their enumerations.
const char* kind(const urdf::Joint& joint) {
  constexpr std::array kinds{"fixed", "revolute", "continuous", "prismatic", "planar", "floating"};
  return kinds[static_cast<std::size_t>(joint.type)];
}

const char* geometry_kind(const urdf::Geometry& geometry) {
  constexpr std::array kinds{"box", "cylinder", "capsule", "sphere", "mesh"};
  return kinds[static_cast<std::size_t>(geometry.type)];
}

// A box's edges or a mesh's scale; a radius; a radius and a length.
Eigen::VectorXd sizes(const urdf::Geometry& geometry) {
  switch (geometry.type) {
    case urdf::GeometryType::kBox:
    case urdf::GeometryType::kMesh:
      return geometry.size;
    case urdf::GeometryType::kSphere:
      return Eigen::VectorXd::Constant(1, geometry.radius);
    case urdf::GeometryType::kCylinder:
    case urdf::GeometryType::kCapsule:
      return Eigen::Vector2d(geometry.radius, geometry.length);
  }
  return {};
}

// The pieces of a link, "visual" or "collision".
std::vector<urdf::Geometry> geometry_of(const urdf::Robot& robot, const std::string& name,
                                        const std::string& role) {
  require(role == "visual" || role == "collision");
  for (const urdf::Link& link : robot.links)
    if (link.name == name) return role == "visual" ? link.visuals : link.collisions;
  return {};
}

using Colour = std::tuple<double, double, double>;

std::optional<Colour> colour(const urdf::Geometry& geometry) {
  if (!geometry.colour) return std::nullopt;
  const Eigen::Vector3d& rgb = *geometry.colour;
  return Colour(rgb.x(), rgb.y(), rgb.z());
}

using MassProperties = std::tuple<double, Eigen::Vector3d, Eigen::Matrix3d>;

// Mass, its centre and the moments about it, by link.
std::map<std::string, MassProperties> inertias(const urdf::Robot& robot) {
  std::map<std::string, MassProperties> bodies;
  for (const auto& [name, parent_joint, inertia, collisions, visuals] : robot.links)
    bodies[name] = {inertia.mass, inertia.center, inertia.moments};
  return bodies;
}

// The robot with other masses, centres and moments of some links.
urdf::Robot with_inertias(urdf::Robot robot, const std::map<std::string, MassProperties>& bodies) {
  for (urdf::Link& link : robot.links)
    if (const auto body = bodies.find(link.name); body != bodies.end())
      std::tie(link.inertia.mass, link.inertia.center, link.inertia.moments) = body->second;
  return robot;
}

std::map<std::string, std::size_t> collisions(const urdf::Robot& robot) {
  std::map<std::string, std::size_t> counts;
  for (const urdf::Link& link : robot.links)
    if (!link.collisions.empty()) counts[link.name] = link.collisions.size();
  return counts;
}

std::vector<std::string> leaf_names(const urdf::Robot& robot) {
  std::vector<bool> is_leaf(robot.links.size(), true);
  for (const urdf::Joint& joint : robot.joints)
    is_leaf[static_cast<std::size_t>(joint.parent)] = false;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < is_leaf.size(); ++i)
    if (is_leaf[i]) names.push_back(robot.links[i].name);
  return names;
}

// Of each mesh among the collision geometry: link, file as written, scale.
std::vector<std::tuple<std::string, std::string, Eigen::Vector3d>> meshes(
    const urdf::Robot& robot) {
  std::vector<std::tuple<std::string, std::string, Eigen::Vector3d>> found;
  for (const urdf::Link& link : robot.links)
    for (const urdf::Geometry& collision : link.collisions)
      if (collision.type == urdf::GeometryType::kMesh)
        found.emplace_back(link.name, collision.file, collision.size);
  return found;
}

}  // namespace

void bind_arm(py::module_& module) {
  py::class_<urdf::Mimic>(module, "Mimic")
      .def_readonly("joint", &urdf::Mimic::joint)
      .def_readonly("multiplier", &urdf::Mimic::multiplier)
      .def_readonly("offset", &urdf::Mimic::offset);

  py::class_<urdf::Joint>(module, "Joint")
      .def_readonly("name", &urdf::Joint::name)
      .def_property_readonly("kind", &kind)
      .def_readonly("mimic", &urdf::Joint::mimic)
      .def_readonly("parent", &urdf::Joint::parent)
      .def_readonly("child", &urdf::Joint::child)
      .def_readonly("axis", &urdf::Joint::axis)
      .def_readonly("lower", &urdf::Joint::lower)
      .def_readonly("upper", &urdf::Joint::upper)
      .def_readonly("friction", &urdf::Joint::friction)
      .def_readonly("damping", &urdf::Joint::damping)
      .def_property_readonly("position",
                             [](const urdf::Joint& joint) { return joint.T_parent_child.position; })
      .def_property_readonly("rotation", [](const urdf::Joint& joint) {
        return Eigen::Matrix3d(joint.T_parent_child.rotation);
      });

  py::class_<urdf::Geometry>(module, "Geometry")
      .def_property_readonly("kind", &geometry_kind)
      .def_property_readonly("sizes", &sizes)
      .def_property_readonly(
          "position", [](const urdf::Geometry& shape) { return shape.T_link_shape.position; })
      .def_readonly("angles", &urdf::Geometry::angles)
      .def_readonly("file", &urdf::Geometry::file)
      .def_property_readonly("colour", &colour);

  py::class_<urdf::Robot>(module, "Robot")
      .def(py::init(&parse), "document"_a)
      .def_readonly("name", &urdf::Robot::name)
      .def_property_readonly("links",
                             [](const urdf::Robot& robot) { return names_of(robot.links); })
      .def_property_readonly("joints",
                             [](const urdf::Robot& robot) { return names_of(robot.joints); })
      .def_readonly("tree", &urdf::Robot::joints)
      .def_property_readonly("leaves", &leaf_names)
      .def_property_readonly("collisions", &collisions)
      .def_property_readonly("meshes", &meshes)
      .def_property_readonly("inertias", &inertias)
      .def("with_inertias", &with_inertias, "bodies"_a)
      .def("geometry", &geometry_of, "link"_a, "role"_a)
      .def("path", &path, "base"_a, "tip"_a)
      .def("hold", &hold, "values"_a);

  py::class_<Chain>(module, "Chain")
      .def(py::init([](const urdf::Robot& robot, const std::string& base, const std::string& tip) {
             return value_or_raise(make_chain(robot, base, tip));
           }),
           "robot"_a, "base"_a, "tip"_a)
      .def_property_readonly("joints", [](const Chain& chain) { return chain.joints(); })
      .def_readonly("joint_names", &Chain::joint_names)
      .def_readonly("lower", &Chain::lower)
      .def_readonly("upper", &Chain::upper)
      .def_readonly("velocity", &Chain::velocity)
      .def_readonly("effort", &Chain::effort)
      .def_property_readonly("middle", &middle)
      .def_readonly("mass", &Chain::mass)
      .def_property_readonly("reach", &reach)
      .def("with_bounds", &with_bounds, "lower"_array, "upper"_array)
      .def(
          "with_tool",
          [](const Chain& chain, const Eigen::Vector3d& position,
             const Eigen::Vector4d& orientation) {
            return with_tool(chain, {so3::to_matrix(orientation), position});
          },
          "position"_a, "orientation"_a)
      .def(
          "with_load",
          [](const Chain& chain, double mass, const Eigen::Vector3d& center,
             const Eigen::Matrix3d& inertia) { return with_load(chain, {mass, center, inertia}); },
          "mass"_a, "center"_a, "inertia"_a)
      .def(
          "forward_kinematics",
          [](const Chain& chain, const RowsRef& q) {
            Poses poses = without_gil([&] { return forward_kinematics_batch(chain, q); });
            return py::make_tuple(std::move(poses.positions), std::move(poses.orientations));
          },
          "q"_array)
      .def(
          "pose",
          [](const Chain& chain, const py::object& q) -> py::object {
            const double* joints = finite_vector(q, chain.joints());
            if (!joints) return py::none();
            const Transform pose = forward_kinematics(chain, joints);
            const Eigen::Vector4d orientation = so3::from_matrix(pose.rotation);
            return py::make_tuple(py::array_t<double>(3, pose.position.data()),
                                  py::array_t<double>(4, orientation.data()));
          },
          "q"_a);

  module.def("jacobian", &jacobian_batch, "chain"_a, "q"_array, Unlocking());
  module.def(
      "jacobian_of_one",
      [](const Chain& chain, const py::object& q) -> py::object {
        const double* joints = finite_vector(q, chain.joints());
        if (!joints) return py::none();
        Kinematics kinematics;
        forward_kinematics(chain, joints, kinematics);
        py::array_t<double> matrix({6, chain.joints()});
        auto entries = matrix.mutable_unchecked<2>();
        bool finite = true;
        for (int column = 0; column < chain.joints(); ++column) {
          const Vector6& twist = kinematics.jacobian[static_cast<std::size_t>(column)];
          finite = finite && twist.allFinite();
          for (int row = 0; row < 6; ++row) entries(row, column) = twist[row];
        }
        return finite ? py::object(matrix) : py::none();
      },
      "chain"_a, "q"_a);
  module.def("jacobian_derivative", &jacobian_derivative_batch, "chain"_a, "q"_array, "qd"_array,
             Unlocking());
  module.def("jacobian_second_derivative", &jacobian_second_derivative_batch, "chain"_a, "q"_array,
             "qd"_array, "qdd"_array, Unlocking());

  py::class_<Dynamics>(module, "Dynamics")
      .def(py::init<const Chain&>(), "chain"_a)
      .def("inverse_dynamics", &Dynamics::torques, "q"_array, "qd"_array, "qdd"_array, "gravity"_a,
           Unlocking())
      .def("mass_matrix", &Dynamics::mass_matrices, "q"_array, Unlocking());
}

}  // namespace leadthrough
