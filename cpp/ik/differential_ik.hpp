#pragma once

// Closed-loop inverse kinematics, one step at a time, for control loops.
//
// Every step is the damped least-squares step (Nakamura and Hanafusa 1986) inside the box that the
// joints' position and velocity limits leave, towards a share of the error that the joints can
// still brake for, plus motion in the null space towards a posture. The joints' velocities change
// towards it in one proportion, as fast as all accelerations allow. A second, small step takes back
// what the kinematics' curvature added.

#include "ik/motion_box.hpp"
#include "ik/solve.hpp"

namespace leadthrough {

struct DifferentialIk {
  Chain chain;
  MotionLimits limits;
  JointVector posture;
  double dt = 1e-3;           // s
  double gain = 20.0;         // 1/s: the error's rate of decay, where the limits let it
  double posture_gain = 1.0;  // 1/s
};

struct DifferentialStep {
  JointVector q, qd;
  double position_error = 0.0;     // m, before the step
  double orientation_error = 0.0;  // rad, 0 where no rotation was asked for
};

// twist: of the target itself, linear first, base frame. q is held inside the limits from where it
// is inside them. Does not allocate.
DifferentialStep differential_step(const DifferentialIk& solver, const IkTarget& target,
                                   const Vector6& twist, const double* q, const double* qd);

}  // namespace leadthrough
