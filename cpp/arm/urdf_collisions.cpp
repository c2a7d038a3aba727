#include "arm/urdf_collisions.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <locale>
#include <sstream>

namespace leadthrough::urdf {

namespace {

using xml::Element;
using xml::Elements;

// Numbers have been checked before; what is left out is zero.
Eigen::Vector3d numbers(const Element& element, std::string_view attribute, int count) {
  Eigen::Vector3d values = Eigen::Vector3d::Zero();
  if (const auto* text = element.find(attribute)) {
    std::istringstream stream{std::string(*text)};
    stream.imbue(std::locale::classic());
    for (int i = 0; i < count; ++i) stream >> values[i];
  }
  return values;
}

Transform origin_of(const Element& origin) {
  const Eigen::Vector3d rpy = numbers(origin, "rpy", 3);
  const Eigen::Quaterniond turn = Eigen::AngleAxisd(rpy[2], Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(rpy[1], Eigen::Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(rpy[0], Eigen::Vector3d::UnitX());
  return {turn.toRotationMatrix(), numbers(origin, "xyz", 3)};
}

// Text of an attribute, with XML's five entities resolved.
std::string resolved(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, char>, 5> kEntities{
      {{"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}}};
  std::string result;
  while (!text.empty()) {
    std::size_t length = 1;
    char letter = text.front();
    for (const auto& [entity, meaning] : kEntities) {
      if (text.substr(0, entity.size()) != entity) continue;
      length = entity.size();
      letter = meaning;
    }
    result += letter;
    text.remove_prefix(length);
  }
  return result;
}

std::optional<std::string> read_shape(const Element& element, Collision& collision) {
  collision.radius = numbers(element, "radius", 1)[0];
  collision.length = numbers(element, "length", 1)[0];
  const bool is_round = collision.radius > 0.0;
  if (element.name == "box") {
    collision.type = ShapeType::kBox;
    collision.size = numbers(element, "size", 3);
    return collision.size.minCoeff() > 0.0 ? std::nullopt
                                           : std::optional("a box's sizes must be above zero");
  }
  if (element.name == "sphere") {
    collision.type = ShapeType::kSphere;
    return is_round ? std::nullopt : std::optional("a sphere's radius must be above zero");
  }
  if (element.name == "cylinder") {
    collision.type = ShapeType::kCylinder;
    return is_round && collision.length > 0.0
               ? std::nullopt
               : std::optional("a cylinder's radius and length must be above zero");
  }
  if (element.name == "capsule") {
    collision.type = ShapeType::kCapsule;
    return is_round && collision.length >= 0.0
               ? std::nullopt
               : std::optional("a capsule's radius must be above zero and its length not below");
  }
  if (element.name != "mesh") return "its collision geometry is of no known kind";
  collision.type = ShapeType::kMesh;
  if (element.find("scale") != nullptr) collision.size = numbers(element, "scale", 3);
  const auto* file = element.find("filename");
  if (file == nullptr || file->empty()) return "a mesh has no filename";
  collision.file = resolved(*file);
  return (collision.size.array() != 0.0).all() ? std::nullopt
                                               : std::optional("a mesh's scale must not be zero");
}

// The first element below `parent` that has this name, or any name where it is empty.
const Element* child(const Elements& elements, std::size_t parent, std::string_view name) {
  for (std::size_t i = parent + 1; i < elements.size(); ++i) {
    if (elements[i].depth <= elements[parent].depth) break;
    if (elements[i].parent != static_cast<int>(parent)) continue;
    if (name.empty() || elements[i].name == name) return &elements[i];
  }
  return nullptr;
}

}  // namespace

std::variant<Collisions, Error> read_collisions(const Elements& elements) {
  Collisions collisions;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const Element& element = elements[i];
    if (element.name != "collision" || element.depth != 2) continue;
    const Element& link = elements[static_cast<std::size_t>(element.parent)];
    if (link.name != "link") continue;
    const std::string name = resolved(*link.find("name"));
    Collision collision;
    if (const Element* origin = child(elements, i, "origin"))
      collision.T_link_shape = origin_of(*origin);
    const Element* geometry = child(elements, i, "geometry");
    const Element* shape =
        geometry == nullptr
            ? nullptr
            : child(elements, static_cast<std::size_t>(geometry - elements.data()), "");
    if (shape == nullptr) return Error{"link '" + name + "'", "a collision has no geometry"};
    if (auto why = read_shape(*shape, collision)) return Error{"link '" + name + "'", *why};
    collisions[name].push_back(std::move(collision));
  }
  return collisions;
}

std::string without_capsules(std::string_view document) {
  constexpr std::string_view kCapsule = "capsule";
  std::string result;
  result.reserve(document.size() + document.size() / kCapsule.size());
  std::size_t done = 0;
  for (std::size_t at = 0; (at = document.find(kCapsule, at)) != document.npos;
       at += kCapsule.size()) {
    const std::string_view before = document.substr(0, at);
    const bool is_tag =
        (at >= 1 && before.substr(at - 1) == "<") || (at >= 2 && before.substr(at - 2) == "</");
    if (!is_tag) continue;
    result.append(document, done, at - done).append("cylinder");
    done = at + kCapsule.size();
  }
  return result.append(document, done, document.npos);
}

}  // namespace leadthrough::urdf
