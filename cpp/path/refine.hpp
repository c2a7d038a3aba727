#pragma once

// The whole curve at once: smooth, near the wished postures, the tip on its path and everything
// clear. Gauss-Newton on a banded system with Levenberg's damping; clearance enters by the
// gradients at the nearest points of all pairs that are near.

#include <vector>

#include "collision/clearance.hpp"
#include "path/tip_task.hpp"

namespace leadthrough::path {

// A place of the curve. room: what its distances should exceed their margins by, m. posture: not
// finite for joints that may stand anywhere.
struct Knot {
  TipTask task;
  JointArray posture;
  double room;
};

// q: one configuration a knot, which comes back better.
void refine(const Chain& chain, const std::vector<Knot>& knots, ClearanceTest& test,
            const std::vector<double>& margins, std::vector<JointArray>& q);

}  // namespace leadthrough::path
