#pragma once

#include <map>

#include "leadthrough/arm/urdf.hpp"
#include "leadthrough/arm/xml_scan.hpp"

namespace leadthrough::urdf {

struct LinkGeometry {
  std::vector<Geometry> collisions, visuals;
};
using GeometryByLink = std::map<std::string, LinkGeometry>;

// The geometry of a document whose structure has been checked. Collision geometry without a size is
// an error; visual geometry without one is allowed.
std::variant<GeometryByLink, Error> read_geometry(const xml::Elements& elements);

// The document with cylinders in place of capsules, for which urdfdom rejects the whole robot.
std::string without_capsules(std::string_view document);

}  // namespace leadthrough::urdf
