#pragma once

// Where a path is looked at first: samples, between two rows too, that lie evenly along the way
// that the tip goes and turns.

#include <vector>

#include "path/tip_task.hpp"

namespace leadthrough::path {

// spacing, turning: how far the tip goes, m, and turns, rad, from one layer to the next at the
// most. The ends are among them.
std::vector<double> layers(const TipPath& path, double spacing, double turning);

}  // namespace leadthrough::path
