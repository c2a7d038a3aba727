#pragma once

#include <optional>

#include "leadthrough/arm/urdf.hpp"
#include "leadthrough/arm/xml_scan.hpp"

namespace leadthrough::urdf {

// The first error in a URDF document's elements and their references, or nothing.
std::optional<Error> check_structure(const xml::Elements& elements);

}  // namespace leadthrough::urdf
