#pragma once

// Small robots for the tests, written as URDF.

#include <string>
#include <variant>

#include "leadthrough/arm/chain.hpp"

namespace leadthrough::test {

inline std::string joint(const std::string& name, const std::string& type,
                         const std::string& parent, const std::string& child,
                         const std::string& inside) {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent +
         "'/><child link='" + child + "'/>" + inside + "</joint>";
}

inline std::string link(const std::string& name) { return "<link name='" + name + "'/>"; }

// Seven joints of three kinds, with tilted axes and fixed parts between: nothing is special.
inline std::string crooked_arm() {
  const std::string limit = "<limit lower='-2.5' upper='2.2' velocity='2' effort='50'/>";
  std::string text = "<robot name='crooked'>";
  for (int i = 0; i <= 9; ++i)
    text += "<link name='l" + std::to_string(i) +
            "'><inertial><origin xyz='0.01 0.02 0.1' rpy='0.1 0 0.2'/><mass value='1.5'/>"
            "<inertia ixx='0.02' ixy='0.001' ixz='0' iyy='0.02' iyz='0' izz='0.01'/></inertial>"
            "</link>";
  text += joint("lift", "prismatic", "l0", "l1",
                "<origin xyz='0.1 0 0.3'/><axis xyz='0 0 1'/>"
                "<limit lower='0' upper='0.35' velocity='0.1' effort='100'/>");
  text += joint("j1", "revolute", "l1", "l2",
                "<origin xyz='0 0 0.1' rpy='0.2 0 0'/><axis xyz='0 0 1'/>" + limit);
  text += joint("bend", "fixed", "l2", "l3", "<origin xyz='0 0.05 0.1' rpy='1.5 0.1 0'/>");
  text += joint("j2", "revolute", "l3", "l4", "<origin xyz='0 0.1 0'/><axis xyz='0 2 0'/>" + limit);
  text += joint("j3", "continuous", "l4", "l5",
                "<origin xyz='0.3 0 0' rpy='0 0.4 0.3'/><axis xyz='1 1 0.5'/>");
  text +=
      joint("j4", "revolute", "l5", "l6", "<origin xyz='0.1 0 0.2'/><axis xyz='0 0 -1'/>" + limit);
  text += joint("j5", "revolute", "l6", "l7",
                "<origin xyz='0 0.1 0.1' rpy='-1.2 0 0'/><axis xyz='0 -1 0'/>" + limit);
  text += joint("j6", "revolute", "l7", "l8", "<origin xyz='0 0 0.1'/><axis xyz='1 0 0'/>" + limit);
  text += joint("flange", "fixed", "l8", "l9", "<origin xyz='0.05 0 0.08' rpy='0 0.7 0'/>");
  return text + "</robot>";
}

inline Chain crooked_chain() {
  const auto robot = std::get<urdf::Robot>(urdf::parse(crooked_arm()));
  return std::get<Chain>(make_chain(robot, "l0", "l9"));
}

}  // namespace leadthrough::test
