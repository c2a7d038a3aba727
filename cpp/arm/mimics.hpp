#pragma once

#include <optional>

#include "arm/urdf.hpp"

namespace leadthrough::urdf {

// Lets every joint that mimics do so by the joint that leads in the end, and fixes those that are
// led by a fixed joint or by a multiplier of zero. Refused: joints that mimic each other.
std::optional<Error> resolve_mimics(Robot& robot);

}  // namespace leadthrough::urdf
