#pragma once

// Signed distance between two convex bodies, with the points where they are nearest.
//
// Every body is a core (point, segment, box, cylinder, convex hull) and all that lies within a
// rounding of it. Cores are measured in closed form where that is simple, else by the algorithm of
// Gilbert, Johnson and Keerthi 1988 with the sub-algorithm of Montanari, Petrinic and Barbieri
// 2017. The depth of cores that overlap comes from the expanding polytope of van den Bergen 2001.

#include <Eigen/Core>

#include "leadthrough/arm/chain.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/collision/cores.hpp"

namespace leadthrough {

// distance: m; if negative, its magnitude is the length of the shortest separating translation, to
// 1e-7 m and never shorter. on_a, on_b: the nearest points, or the deepest ones. normal: unit, the
// direction in which b separates from a.
struct Separation {
  double distance;
  Eigen::Vector3d on_a, on_b;
  Eigen::Vector3d normal;
};

// In the frame in which both poses are given. A distance of at least `cutoff` may be returned as
// any value from `cutoff` up to the true one, and then without the points, but with a normal along
// which the bodies are that far apart.
Separation separation(const Convex& a, const Transform& T_base_a, const Convex& b,
                      const Transform& T_base_b, double cutoff = kInfinity);

// True if the distance is at least `least`, m. normal: a guess of the unit vector from a to b along
// which it is, updated to a better one. Cores that overlap count as infinitely deep.
bool apart(const Convex& a, const Transform& T_base_a, const Convex& b, const Transform& T_base_b,
           double least, Eigen::Vector3d& normal);

}  // namespace leadthrough
