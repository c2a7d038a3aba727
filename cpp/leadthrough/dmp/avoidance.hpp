#pragma once

// Coupling terms that keep a primitive's motion out of obstacles and inside limits.
//
// Three act together: a steering term rotates the velocity away from an obstacle's middle early
// (after Hoffmann et al. 2009 and Pastor et al. 2009); a barrier adds the least acceleration that
// keeps h'' + 2 rate h' + rate^2 h >= 0 for every distance h, so that none falls below 0 by more
// than finite steps leave (Ames et al. 2019, "Control barrier functions"; here of second order);
// and a motion that presses on an obstacle is led around it, by the shortest detour from the line
// from start to goal. All rates are per unit of phase.

#include <vector>

#include "leadthrough/collision/shapes.hpp"
#include "leadthrough/dmp/primitive.hpp"

namespace leadthrough::dmp {

struct Obstacle {
  Shape shape;
  double margin;  // distance to keep, > 0
};

struct AvoidanceScene {
  std::vector<Obstacle> obstacles;  // about the first two or three channels
  double reach;                     // distance at which steering has faded to 1 / e
  Vector lower, upper;              // (channels), or empty
};

struct Passage {
  Rollout rollout;
  double last_push;  // the last phase at which steering or a barrier mattered, or the first one
};

// Advances the state by `span` > 0 of phase. Returns true if steering or a barrier acted.
bool advance_around(const Forces& forces, const Course& course, const AvoidanceScene& scene,
                    const Vector& push, double span, State& state);

Passage rollout_around(const Forces& forces, const Course& course, const AvoidanceScene& scene,
                       State state, const VectorRef& phases);

}  // namespace leadthrough::dmp
