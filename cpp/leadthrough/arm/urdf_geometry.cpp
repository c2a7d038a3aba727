#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <locale>
#include <sstream>
#include <utility>

#include "leadthrough/arm/urdf_parts.hpp"

namespace leadthrough::urdf {

namespace {

using xml::Element;
using xml::Elements;

// Numbers have been checked before; absent ones are zero.
Eigen::Vector3d numbers(const Element& element, std::string_view attribute, int count) {
  Eigen::Vector3d values = Eigen::Vector3d::Zero();
  if (const auto* text = element.find(attribute)) {
    std::istringstream stream{std::string(*text)};
    stream.imbue(std::locale::classic());
    for (int i = 0; i < count; ++i) stream >> values[i];
  }
  return values;
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

// The first element of this name below another, or of any name if it is empty.
const Element* child(const Elements& elements, const Element& of, std::string_view name) {
  const auto parent = static_cast<std::size_t>(&of - elements.data());
  for (std::size_t i = parent + 1; i < elements.size(); ++i) {
    if (elements[i].depth <= elements[parent].depth) break;
    if (elements[i].parent != static_cast<int>(parent)) continue;
    if (name.empty() || elements[i].name == name) return &elements[i];
  }
  return nullptr;
}

void read_origin(const Element& origin, Geometry& geometry) {
  geometry.angles = numbers(origin, "rpy", 3);
  const Eigen::Quaterniond rotation =
      Eigen::AngleAxisd(geometry.angles[2], Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(geometry.angles[1], Eigen::Vector3d::UnitY()) *
      Eigen::AngleAxisd(geometry.angles[0], Eigen::Vector3d::UnitX());
  geometry.T_link_shape = {rotation.toRotationMatrix(), numbers(origin, "xyz", 3)};
}

// False for geometry of no known kind.
bool read_shape(const Element& element, Geometry& geometry) {
  constexpr std::array<std::pair<std::string_view, GeometryType>, 5> kTypes{
      {{"box", GeometryType::kBox},
       {"cylinder", GeometryType::kCylinder},
       {"capsule", GeometryType::kCapsule},
       {"sphere", GeometryType::kSphere},
       {"mesh", GeometryType::kMesh}}};
  const auto type = std::find_if(kTypes.begin(), kTypes.end(),
                                 [&](const auto& each) { return each.first == element.name; });
  if (type == kTypes.end()) return false;
  geometry.type = type->second;
  geometry.radius = numbers(element, "radius", 1)[0];
  geometry.length = numbers(element, "length", 1)[0];
  if (geometry.type == GeometryType::kBox) geometry.size = numbers(element, "size", 3);
  if (element.find("scale") != nullptr) geometry.size = numbers(element, "scale", 3);
  if (const auto* file = element.find("filename")) geometry.file = resolved(*file);
  return true;
}

// Impossible sizes, or nothing.
std::optional<std::string> fault(const Geometry& geometry) {
  const bool is_round = geometry.radius > 0.0;
  switch (geometry.type) {
    case GeometryType::kBox:
      if (geometry.size.minCoeff() > 0.0) return std::nullopt;
      return "a box's sizes must be above zero";
    case GeometryType::kSphere:
      if (is_round) return std::nullopt;
      return "a sphere's radius must be above zero";
    case GeometryType::kCylinder:
      if (is_round && geometry.length > 0.0) return std::nullopt;
      return "a cylinder's radius and length must be above zero";
    case GeometryType::kCapsule:
      if (is_round && geometry.length >= 0.0) return std::nullopt;
      return "a capsule's radius must be above zero and its length not below";
    case GeometryType::kMesh:
      if (geometry.file.empty()) return "a mesh has no filename";
      if ((geometry.size.array() != 0.0).all()) return std::nullopt;
      return "a mesh's scale must not be zero";
  }
  return std::nullopt;
}

using Colour = std::optional<Eigen::Vector3d>;
using Colours = std::map<std::string_view, Colour>;  // by the material's name, as written

// Red, green and blue of a material; none where it states no colour or no numbers.
Colour colour_of(const Elements& elements, const Element& material) {
  const Element* colour = child(elements, material, "color");
  if (colour == nullptr) return std::nullopt;
  const auto* text = colour->find("rgba");
  if (text == nullptr) return Eigen::Vector3d::Constant(0.5);
  std::istringstream stream{std::string(*text)};
  stream.imbue(std::locale::classic());
  Eigen::Vector3d values;
  for (double& value : values) stream >> value;
  return stream.fail() ? Colour() : Colour(values);
}

Colours shared_colours(const Elements& elements) {
  Colours colours;
  for (const Element& element : elements)
    if (element.name == "material" && element.depth == 1)
      if (const auto* name = element.find("name")) {
        if (const Colour colour = colour_of(elements, element)) colours[*name] = colour;
      }
  return colours;
}

// A <visual> or <collision>, or the error.
std::variant<Geometry, std::string> read_piece(const Elements& elements, const Element& piece,
                                               const Colours& colours) {
  Geometry geometry;
  if (const Element* origin = child(elements, piece, "origin")) read_origin(*origin, geometry);
  const Element* parent = child(elements, piece, "geometry");
  const Element* shape = parent == nullptr ? nullptr : child(elements, *parent, "");
  const std::string kind(piece.name);
  if (shape == nullptr) return "a " + kind + " has no geometry";
  if (!read_shape(*shape, geometry)) return "its " + kind + " geometry is of no known kind";
  if (const Element* material = child(elements, piece, "material")) {
    geometry.colour = colour_of(elements, *material);
    const auto* name = material->find("name");
    const auto shared = name == nullptr ? colours.end() : colours.find(*name);
    if (!geometry.colour && shared != colours.end()) geometry.colour = shared->second;
  }
  return geometry;
}

}  // namespace

std::variant<GeometryByLink, Error> read_geometry(const Elements& elements) {
  GeometryByLink found;
  const Colours colours = shared_colours(elements);
  for (const Element& element : elements) {
    const bool is_collision = element.name == "collision";
    if (element.depth != 2 || (!is_collision && element.name != "visual")) continue;
    const Element& link = elements[static_cast<std::size_t>(element.parent)];
    if (link.name != "link") continue;
    const std::string name = resolved(*link.find("name"));
    auto piece = read_piece(elements, element, colours);
    if (const auto* why = std::get_if<std::string>(&piece))
      return Error{"link '" + name + "'", *why};
    auto& geometry = std::get<Geometry>(piece);
    if (is_collision)
      if (const auto why = fault(geometry)) return Error{"link '" + name + "'", *why};
    auto& own = found[name];
    (is_collision ? own.collisions : own.visuals).push_back(std::move(geometry));
  }
  return found;
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
