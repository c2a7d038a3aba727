#pragma once

// Upper bounds on the displacement of an arm's shapes for a change of its joints.

#include <vector>

#include "leadthrough/arm/run_down.hpp"
#include "leadthrough/collision/check.hpp"

namespace leadthrough::collision {

// Largest distance of any point of each shape from each joint's axis, m; 1 for a prismatic joint,
// whose value is a length itself. extent: the largest absolute value of each joint.
std::vector<MovingValues> reaches(const CollisionScene& scene, const MovingValues& extent);

// Upper bound on the relative displacement of a pair of shapes for a change of the joints.
double pair_motion(const CollisionScene& scene, const std::vector<MovingValues>& reach,
                   const ShapePair& pair, const MovingValues& change);

}  // namespace leadthrough::collision
