#pragma once

#include <map>

#include "arm/urdf.hpp"
#include "arm/xml_scan.hpp"

namespace leadthrough::urdf {

using Collisions = std::map<std::string, std::vector<Collision>>;  // by link

// The collision geometry of a document whose structure has been checked.
std::variant<Collisions, Error> read_collisions(const xml::Elements& elements);

// The document with cylinders in place of capsules, at which urdfdom refuses the whole robot.
std::string without_capsules(std::string_view document);

}  // namespace leadthrough::urdf
