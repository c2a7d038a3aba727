#pragma once

// Bounds on how far the shapes of an arm move while its joints do.

#include <vector>

#include "arm/run_down.hpp"
#include "collision/check.hpp"

namespace leadthrough::collision {

// How far any point of each shape can be from each joint's axis, m; 1 for a prismatic joint, whose
// value is a way itself. extent: the largest absolute value that each joint takes.
std::vector<MovingValues> reaches(const CollisionScene& scene, const MovingValues& extent);

// A bound on how far the shapes of a pair move against each other while the joints change.
double pair_motion(const CollisionScene& scene, const std::vector<MovingValues>& reach,
                   const ShapePair& pair, const MovingValues& change);

}  // namespace leadthrough::collision
