#pragma once

// Obstacles and attached objects as collision checks take them.

#include <vector>

#include "collision/check.hpp"
#include "collision/signed_distance.hpp"

namespace leadthrough {

PlacedShapes placed_shapes(const std::vector<Shape>& shapes);

}  // namespace leadthrough
