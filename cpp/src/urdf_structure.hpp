#pragma once

#include <optional>
#include <string_view>

#include "leadthrough/urdf.hpp"

namespace leadthrough::urdf {

// What is wrong with a URDF document's elements and their references, or nothing.
std::optional<Error> check_structure(std::string_view document);

}  // namespace leadthrough::urdf
