#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "leadthrough/ik.hpp"
#include "leadthrough/urdf.hpp"
#include "parts.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

// A document's text may be cut inside a character.
py::str to_text(const std::string& text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "replace"));
}

template <typename Value>
Value value_or_raise(std::variant<Value, urdf::Error>&& answer) {
  if (const auto* error = std::get_if<urdf::Error>(&answer)) {
    const py::object type = py::module_::import("leadthrough.errors").attr("InvalidRobot");
    PyErr_SetObject(type.ptr(), type(to_text(error->where), to_text(error->why)).ptr());
    throw py::error_already_set();
  }
  return std::get<Value>(std::move(answer));
}

urdf::Robot parse(const std::string& document) {
  auto answer = [&] {
    const py::gil_scoped_release release;
    return urdf::parse(document);
  }();
  return value_or_raise(std::move(answer));
}

std::vector<std::string> link_names(const urdf::Robot& robot) {
  std::vector<std::string> names;
  for (const urdf::Link& link : robot.links) names.push_back(link.name);
  return names;
}

std::vector<std::string> joint_names(const urdf::Robot& robot) {
  std::vector<std::string> names;
  for (const urdf::Joint& joint : robot.joints) names.push_back(joint.name);
  return names;
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

}  // namespace

void bind_chain(py::module_& module) {
  py::class_<urdf::Robot>(module, "Robot")
      .def(py::init(&parse), py::arg("document"))
      .def_readonly("name", &urdf::Robot::name)
      .def_property_readonly("links", &link_names)
      .def_property_readonly("joints", &joint_names)
      .def_property_readonly("leaves", &leaf_names);

  py::class_<Chain>(module, "Chain")
      .def(py::init([](const urdf::Robot& robot, const std::string& base, const std::string& tip) {
             return value_or_raise(make_chain(robot, base, tip));
           }),
           py::arg("robot"), py::arg("base"), py::arg("tip"))
      .def_readonly("joint_names", &Chain::joint_names)
      .def_readonly("lower", &Chain::lower)
      .def_readonly("upper", &Chain::upper)
      .def_readonly("velocity", &Chain::velocity)
      .def_readonly("effort", &Chain::effort)
      .def_property_readonly("middle", &middle)
      .def(
          "with_bounds",
          [](const Chain& chain, const Eigen::Ref<const Eigen::VectorXd>& lower,
             const Eigen::Ref<const Eigen::VectorXd>& upper) {
            require(lower.size() == chain.joints() && upper.size() == chain.joints());
            Chain bounded = chain;
            bounded.lower = lower;
            bounded.upper = upper;
            return bounded;
          },
          py::arg("lower").noconvert(), py::arg("upper").noconvert())
      .def(
          "forward_kinematics",
          [](const Chain& chain, const Eigen::Ref<const Rows>& q) {
            require(q.cols() == chain.joints());
            Poses poses;
            {
              const py::gil_scoped_release release;
              poses = forward_kinematics_batch(chain, q);
            }
            return py::make_tuple(std::move(poses.positions), std::move(poses.orientations));
          },
          py::arg("q").noconvert());
}

}  // namespace leadthrough
