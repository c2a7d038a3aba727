#pragma once

// The parts of reading a URDF around urdfdom.

#include <map>
#include <optional>

#include "leadthrough/arm/urdf.hpp"
#include "leadthrough/arm/xml_scan.hpp"

namespace leadthrough::urdf {

// The first error in a URDF document's elements and their references, or nothing.
std::optional<Error> check_structure(const xml::Elements& elements);

struct LinkGeometry {
  std::vector<Geometry> collisions, visuals;
};
using GeometryByLink = std::map<std::string, LinkGeometry>;

// The geometry of a document whose structure has been checked. Collision geometry without a size is
// an error; visual geometry without one is allowed.
std::variant<GeometryByLink, Error> read_geometry(const xml::Elements& elements);

// The document with cylinders in place of capsules, for which urdfdom rejects the whole robot.
std::string without_capsules(std::string_view document);

// Resolves chains of mimics, so that every mimic joint refers to one that mimics none, and fixes
// those with a fixed leader or a multiplier of zero. Error: joints that mimic each other.
std::optional<Error> resolve_mimics(Robot& robot);

}  // namespace leadthrough::urdf
