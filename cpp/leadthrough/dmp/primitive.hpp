#pragma once

// Dynamic movement primitives: a critically damped spring pulls to a reference r from start to
// goal, and a learned force f shapes the path. Everything runs over the phase u, which is time over
// duration:
//
//   y = r(u) + e,   e'' = -2 rate e' - rate^2 e + f(u) + push
//
// f is piecewise linear over evenly spaced phases, and every step is the exact solution: stable,
// and the same motion for steps of any length. Ijspeert et al. 2013, eq. 2.1.

#include <functional>

#include "leadthrough/dmp/path.hpp"

namespace leadthrough::dmp {

enum class Canonical { kDiscrete, kRhythmic };  // beyond phase 1 there is no force, or it repeats

// The learned forces. At least one interval.
struct Forces {
  Rows nodes;   // (intervals + 1, channels), at even phases from 0 to 1
  Vector fade;  // (intervals + 1), what `Course::drive` multiplies
  double rate;  // of the spring, per unit of phase
  Canonical canonical;
};

// The primitive for one query.
struct Course {
  Path reference;  // r, from phase 0, or from where it was changed last
  Vector gain;     // (channels), multiplies the learned force
  Vector drive;    // (channels), multiplies the fade, which is added to the force
};

struct State {
  Vector value, slope;  // (channels): y and dy/du
  double phase;
};

struct Rollout {
  Rows values, slopes;  // (n, channels)
};

// Advances the state by `span` > 0 of phase, under an extra force that is constant meanwhile.
void advance(const Forces& forces, const Course& course, const Vector& push, double span,
             State& state);

// d2y/du2 without a push.
void acceleration(const Forces& forces, const Course& course, const State& state, Vector& result);

// Phases count periods; between more of them floating-point numbers lose the nodes.
constexpr double kMaxPhase = 1e12;

// Throws std::invalid_argument unless all have the same channels and the phases lie between 0 and
// kMaxPhase; so do the functions below.
void check_run(const Forces& forces, const Course& course, const State& state,
               const VectorRef& phases);

// Calls back with the index of each of increasing phases and the state there, from a state at the
// first of them on.
void roll(const Forces& forces, const Course& course, State state, const VectorRef& phases,
          const std::function<void(Eigen::Index, const State&)>& take);

// The motion at increasing phases, from a state at the first of them on.
Rollout rollout(const Forces& forces, const Course& course, State state, const VectorRef& phases);

}  // namespace leadthrough::dmp
