// The checks of a URDF that must precede urdfdom, which drops the faulty elements or crashes.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <locale>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "leadthrough/arm/urdf_parts.hpp"

namespace leadthrough::urdf {

namespace {

using xml::Element;
using xml::Elements;

struct JointElement {
  const Element* joint = nullptr;
  const Element* parent = nullptr;
  const Element* child = nullptr;
  const Element* limit = nullptr;
  const Element* mimic = nullptr;
};

struct Structure {
  std::map<std::string_view, const Element*> links;
  std::map<std::string_view, JointElement> joints;
};

std::string quoted(std::string_view name) { return "'" + std::string(name) + "'"; }

std::string element_text(const Element& element) {
  const auto* name = element.find("name");
  return std::string(element.name) + (name == nullptr ? "" : " " + quoted(*name));
}

// No robot is larger or heavier; beyond it products of a robot's parameters overflow.
constexpr double kMaxNumber = 1e9;  // m, kg, kg m^2
constexpr double kMaxFinite = std::numeric_limits<double>::max();

// As urdfdom reads it, independent of the process's locale; infinity and NaN are invalid.
bool is_number(const std::string& text, double largest) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  double value = 0.0;
  stream >> value;
  return !stream.fail() && stream.eof() && std::abs(value) <= largest;
}

bool are_numbers(std::string_view text, int count, double largest) {
  int found = 0;
  std::size_t at = 0;
  while ((at = text.find_first_not_of(' ', at)) != text.npos) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    if (found == count || !is_number(std::string(text.substr(at, end - at)), largest)) return false;
    at = end;
    ++found;
  }
  return found == count;
}

// Count of numbers in an attribute, by its element and name; 0 for text.
int number_count(std::string_view element, std::string_view attribute) {
  constexpr std::array<std::string_view, 6> kMoments{"ixx", "ixy", "ixz", "iyy", "iyz", "izz"};
  constexpr std::array<std::string_view, 4> kLimits{"lower", "upper", "velocity", "effort"};
  const auto among = [attribute](const auto& names) {
    return std::find(names.begin(), names.end(), attribute) != names.end();
  };
  if (element == "origin" || element == "axis")
    return attribute == "xyz" || attribute == "rpy" ? 3 : 0;
  if (element == "limit") return among(kLimits) ? 1 : 0;
  if (element == "inertia") return among(kMoments) ? 1 : 0;
  if (element == "dynamics") return attribute == "damping" || attribute == "friction" ? 1 : 0;
  if (element == "mass") return attribute == "value" ? 1 : 0;
  if (element == "mimic") return attribute == "multiplier" || attribute == "offset" ? 1 : 0;
  if (element == "box") return attribute == "size" ? 3 : 0;
  if (element == "mesh") return attribute == "scale" ? 3 : 0;
  if (element == "sphere" || element == "cylinder" || element == "capsule")
    return attribute == "radius" || attribute == "length" ? 1 : 0;
  return 0;
}

// The link or joint directly under the root that an element belongs to, or nullptr.
const Element* owner(const Elements& elements, const Element& element) {
  const Element* at = &element;
  while (at->depth > 1) at = &elements[static_cast<std::size_t>(at->parent)];
  return at->depth == 1 && (at->name == "link" || at->name == "joint") ? at : nullptr;
}

std::optional<Error> check_numbers(const Elements& elements) {
  for (const Element& element : elements) {
    for (const auto& [name, value] : element.attributes) {
      const int count = number_count(element.name, name);
      // Some robots state a vast limit for none; mimics are bounded with their leaders, and a vast
      // friction locks a joint.
      const bool is_free =
          element.name == "limit" || element.name == "mimic" || element.name == "dynamics";
      const double largest = is_free ? kMaxFinite : kMaxNumber;
      if (count == 0 || are_numbers(value, count, largest)) continue;
      const Element* part = owner(elements, element);
      if (part == nullptr) continue;
      return Error{element_text(*part),
                   std::string(element.name) + " " + std::string(name) + ": expected " +
                       std::to_string(count) + (count == 1 ? " finite number" : " finite numbers") +
                       (is_free ? "" : " up to 1e9") + ", got " + quoted(value.substr(0, 60))};
    }
  }
  return std::nullopt;
}

std::optional<Error> collect(const Elements& elements, Structure& structure) {
  for (const Element& element : elements) {
    const bool is_link = element.name == "link";
    if (element.depth != 1 || (!is_link && element.name != "joint")) continue;
    const auto* name = element.find("name");
    if (name == nullptr || name->empty()) return Error{std::string(element.name), "has no name"};
    const bool is_new = is_link
                            ? structure.links.try_emplace(*name, &element).second
                            : structure.joints.try_emplace(*name, JointElement{&element}).second;
    if (!is_new) return Error{element_text(element), "the name appears twice"};
  }
  if (structure.links.empty()) return Error{"robot", "has no link"};
  if (structure.links.size() > kMaxLinks)
    return Error{"robot", "has more than " + std::to_string(kMaxLinks) + " links"};
  for (const Element& element : elements) {
    if (element.depth != 2) continue;
    const Element& joint = elements[static_cast<std::size_t>(element.parent)];
    if (joint.name != "joint") continue;
    JointElement& parts = structure.joints[*joint.find("name")];
    if (element.name == "parent") parts.parent = &element;
    if (element.name == "child") parts.child = &element;
    if (element.name == "limit") parts.limit = &element;
    if (element.name == "mimic") parts.mimic = &element;
  }
  return std::nullopt;
}

std::optional<Error> check_end(const Structure& structure, const Element& joint, const Element* end,
                               const char* role) {
  const auto* link = end == nullptr ? nullptr : end->find("link");
  if (link == nullptr) return Error{element_text(joint), std::string("has no ") + role + " link"};
  if (structure.links.count(*link) == 0)
    return Error{element_text(joint),
                 std::string(role) + " link " + quoted(*link) + " does not exist"};
  return std::nullopt;
}

std::optional<Error> check_limit(const JointElement& parts, std::string_view type) {
  const bool bounded = type == "revolute" || type == "prismatic";
  const std::string where = element_text(*parts.joint);
  if (parts.limit == nullptr) {
    if (bounded) return Error{where, "a " + std::string(type) + " joint needs a <limit>"};
    return std::nullopt;
  }
  for (const char* name : {"velocity", "effort"})
    if (parts.limit->find(name) == nullptr)
      return Error{where, std::string("its <limit> has no ") + name};
  return std::nullopt;
}

std::optional<Error> check_joint(const Structure& structure, const JointElement& parts) {
  constexpr std::array<std::string_view, 6> kTypes{"revolute", "continuous", "prismatic",
                                                   "fixed",    "floating",   "planar"};
  const std::string where = element_text(*parts.joint);
  const auto* type = parts.joint->find("type");
  if (type == nullptr) return Error{where, "has no type"};
  if (std::find(kTypes.begin(), kTypes.end(), *type) == kTypes.end())
    return Error{where, "its type " + quoted(*type) + " is unknown"};
  if (auto error = check_end(structure, *parts.joint, parts.parent, "parent")) return error;
  if (auto error = check_end(structure, *parts.joint, parts.child, "child")) return error;
  if (auto error = check_limit(parts, *type)) return error;
  if (parts.mimic == nullptr) return std::nullopt;
  const auto* followed = parts.mimic->find("joint");
  if (followed == nullptr) return Error{where, "mimics no named joint"};
  if (structure.joints.count(*followed) == 0)
    return Error{where, "mimics " + quoted(*followed) + ", which does not exist"};
  return std::nullopt;
}

// A tree: no link has two parents, one link has none, and every link descends from it.
std::optional<Error> check_tree(const Structure& structure) {
  std::map<std::string_view, const JointElement*> parent_of;
  for (const auto& [name, parts] : structure.joints) {
    const auto link = *parts.child->find("link");
    if (!parent_of.try_emplace(link, &parts).second)
      return Error{"link " + quoted(link), "is the child of two joints"};
  }
  std::vector<std::string_view> roots;
  for (const auto& [name, element] : structure.links)
    if (parent_of.count(name) == 0) roots.push_back(name);
  if (roots.empty()) return Error{"robot", "has no root link: its joints form a loop"};
  std::sort(roots.begin(), roots.end());
  if (roots.size() > 1)
    return Error{"robot", "has several root links, among them " + quoted(roots[0]) + " and " +
                              quoted(roots[1])};
  std::map<std::string_view, bool> hangs{{roots.front(), true}};
  for (const auto& [name, element] : structure.links) {
    std::vector<std::string_view> path;
    std::string_view at = name;
    while (hangs.try_emplace(at, false).second) {
      path.push_back(at);
      at = *parent_of.at(at)->parent->find("link");
    }
    if (!hangs[at]) return Error{"link " + quoted(at), "is part of a loop of joints"};
    for (const auto link : path) hangs[link] = true;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Error> check_structure(const Elements& elements) {
  if (elements.front().name != "robot")
    return Error{"document", "expected <robot>, got <" + std::string(elements.front().name) + ">"};
  Structure structure;
  if (auto error = collect(elements, structure)) return error;
  for (const auto& [name, parts] : structure.joints)
    if (auto error = check_joint(structure, parts)) return error;
  if (auto error = check_tree(structure)) return error;
  return check_numbers(elements);
}

}  // namespace leadthrough::urdf
