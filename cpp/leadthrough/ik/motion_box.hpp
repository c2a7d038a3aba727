#pragma once

// Bounds of the joints' motion in the next sampling interval, such that their position, velocity
// and acceleration limits can hold in every later interval as well.
// After Flacco, De Luca and Khatib 2015, "Control of redundant robots under hard joint constraints:
// saturation in the null space", eq. (4), with the braking distance of a sampled motion.

#include "leadthrough/arm/chain.hpp"

namespace leadthrough {

struct MotionBox {
  JointVector lower, upper;
};

// Infinite where there is none.
struct MotionLimits {
  JointVector lower, upper;  // rad or m
  JointVector velocity, acceleration;
};

// The largest speed, held for one interval `dt` and then lowered by acceleration * dt in each, that
// comes to rest within `distance` >= 0.
double braking_speed(double distance, double acceleration, double dt);

// Velocities for the next interval: q moves by dt times them. A joint outside its limits may not
// move further out. If qd is nullptr the present velocity is unknown and accelerations are bounded
// only by the remaining braking distance; if qd is too fast to stop in time, the joint brakes at
// the acceleration limit.
MotionBox velocity_box(const MotionLimits& limits, const double* q, const double* qd, double dt);

// Accelerations for the next interval: qd grows by dt times them, q by dt times the new qd.
MotionBox acceleration_box(const MotionLimits& limits, const double* q, const double* qd,
                           double dt);

}  // namespace leadthrough
