#pragma once

// Optimisation of the whole curve at once: smooth, near the preferred postures, the tip on its path
// and all pairs clear. Gauss-Newton on a banded system with Levenberg's damping; clearance enters
// by the gradients at the nearest points of all near pairs.

#include <vector>

#include "leadthrough/collision/clearance.hpp"
#include "leadthrough/path/tip_task.hpp"

namespace leadthrough::path {

// A knot of the curve. room: desired excess of its distances over their margins, m. posture: not
// finite for joints without a preference.
struct Knot {
  TipTask task;
  JointArray posture;
  double room;
};

// q: one configuration per knot, improved in place.
void refine(const Chain& chain, const std::vector<Knot>& knots, ClearanceTest& test,
            const std::vector<double>& margins, std::vector<JointArray>& q);

}  // namespace leadthrough::path
