#pragma once

#include <optional>

#include "leadthrough/arm/urdf.hpp"

namespace leadthrough::urdf {

// Resolves chains of mimics, so that every mimic joint refers to one that mimics none, and fixes
// those with a fixed leader or a multiplier of zero. Error: joints that mimic each other.
std::optional<Error> resolve_mimics(Robot& robot);

}  // namespace leadthrough::urdf
