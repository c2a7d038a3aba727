#pragma once

// Closed-loop inverse kinematics, one step at a time, for control loops.
//
// Every step is the damped least-squares step (Nakamura and Hanafusa 1986) inside the box of the
// joints' position and velocity limits, towards a fraction of the error from which the joints can
// still brake, plus motion in the null space towards a posture. All joints' velocities change
// towards it by one fraction, as large as the acceleration limits allow. A second, small step
// removes the error due to the kinematics' curvature.

#include "leadthrough/ik/motion_box.hpp"
#include "leadthrough/ik/solve.hpp"

namespace leadthrough {

struct DifferentialIk {
  Chain chain;
  MotionLimits limits;
  JointVector posture;
  double dt = 1e-3;           // s
  double gain = 20.0;         // 1/s: the error's rate of decay, if the limits allow it
  double posture_gain = 1.0;  // 1/s
};

struct DifferentialStep {
  JointVector q, qd;
  double position_error = 0.0;     // m, before the step
  double orientation_error = 0.0;  // rad, 0 for targets without a rotation
};

// Throws std::invalid_argument unless the limits and the posture have one number a joint.
void check_sizes(const DifferentialIk& solver);

// Positions, velocities and twists beyond this are refused: no robot has them, in m, rad and s.
constexpr double kMaxStepInput = 1e6;

// q, qd: (joints,). twist: of the target itself, linear first, base frame. A joint inside its
// limits never leaves them. Throws std::invalid_argument for other sizes and numbers that are not
// finite. Does not allocate.
DifferentialStep differential_step(const DifferentialIk& solver, const IkTarget& target,
                                   const Vector6& twist, const VectorRef& q, const VectorRef& qd);

}  // namespace leadthrough
