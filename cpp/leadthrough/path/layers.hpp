#pragma once

// Samples at which a path is examined first, possibly between two rows: evenly spaced along the
// tip's translation and rotation.

#include <vector>

#include "leadthrough/path/tip_task.hpp"

namespace leadthrough::path {

// spacing, rotation_spacing: how far the tip goes, m, and turns, rad, from one layer to the next at
// the most. The ends are among them.
std::vector<double> layers(const TipPath& path, double spacing, double rotation_spacing);

}  // namespace leadthrough::path
