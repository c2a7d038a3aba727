#pragma once

// Stacks of tasks with strict priorities for redundant arms, in velocities or accelerations.
//
// Each level moves the arm only in the null space of the levels above it (Siciliano and Slotine
// 1991, "A general framework for managing multiple tasks in highly redundant robotic systems",
// eqs. 8 to 10); that null space is the exact one of the levels' numerical ranges, so a lower level
// never disturbs a higher one. A level's own motion is damped where it is nearly singular
// (Chiaverini 1997, numerical filtering). The joints' bounds hold at every level: at an active
// bound the level's null space compensates, and the level itself is relaxed only after that, as in
// saturation in the null space (Flacco, De Luca and Khatib 2015). The motion is the optimum of a
// strictly convex program (Kanoun, Lamiraux and Wieber 2011), hence continuous when a bound becomes
// active.

#include <vector>

#include "leadthrough/ik/motion_box.hpp"

namespace leadthrough {

using TaskMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMaxJoints, kMaxJoints>;

// jacobian * motion is to equal `wanted` or, if unilateral (one row), to be at least that.
struct Level {
  TaskMatrix jacobian;
  JointVector wanted;
  bool unilateral = false;
  double activation = 1.0;  // of a unilateral level, 0 (absent) to 1
  double relief = 1.0;      // in units of `wanted`, relaxation of a weakly active level
  bool bounded = false;     // output: a bound or a level above prevents `wanted`
};

// kForward: from the highest level down, each in the null space of the levels above; a weakly
// active level demands relief * (1 / activation - 1) less.
// kReverse: from the lowest level up, each correcting the motion so far with the least disturbance
// of the levels below, in their order, by the fraction of its activation (Flacco and De Luca 2014,
// "A reverse priority approach to multi-task control of redundant robots", and 2015, "Unilateral
// constraints in the reverse priority redundancy resolution method"). The two agree if every level
// is fully active.
enum class PriorityScheme { kForward, kReverse };

// Rate bound of joints near singularities, at which singular or unreachable tasks are damped so
// that the closed loop does not oscillate: 1/s for velocities, 1/s^2 for accelerations.
constexpr double kVelocityQuickness = 40.0;
constexpr double kAccelerationQuickness = kVelocityQuickness * kVelocityQuickness;

// The motion inside the box. Levels are ordered by priority, the highest first.
JointVector resolve(std::vector<Level>& levels, const MotionBox& box, PriorityScheme scheme,
                    double quickness = kVelocityQuickness);

}  // namespace leadthrough
