#pragma once

// Upper bounds on the displacement of an arm's shapes for a change of its joints.

#include <vector>

#include "leadthrough/arm/run_down.hpp"
#include "leadthrough/collision/check.hpp"

namespace leadthrough::collision {

// Largest distance from each joint's axis, m, of points within `radius` of `offset` in a frame; 1
// for a prismatic joint, whose value is a length itself; 0 for joints that do not move the frame.
// extent: the largest absolute value of each joint.
MovingValues reach_of_point(const Chain& chain, int frame, Eigen::Vector3d offset, double radius,
                            const MovingValues& extent);
// The same for any point of each shape.
std::vector<MovingValues> reaches(const CollisionScene& scene, const MovingValues& extent);

// Largest absolute value of each moving joint inside the ranges in which joints are sampled.
MovingValues sampled_extent(const Chain& chain);

// Upper bound on the relative displacement of a pair of shapes for a change of the joints.
double pair_motion(const CollisionScene& scene, const std::vector<MovingValues>& reach,
                   const ShapePair& pair, const MovingValues& change);

}  // namespace leadthrough::collision
