#pragma once

// Frames along a chain: poses, Jacobians, velocities and the accelerations that remain where the
// joints' velocities are constant (Jdot qd). Forward recursion of Luh, Walker and Paul 1980.

#include <array>

#include "leadthrough/arm/chain.hpp"

namespace leadthrough {

// A frame that the first `moving` moving joints of a chain carry.
struct Frame {
  int moving = 0;
  Transform T_joint_frame;  // in the frame of the last of these joints, rotated about its z
};

// The tip of a chain; of a chain's upper part, a frame of the whole chain.
Frame tip_frame(const Chain& chain);

// All in the base frame.
struct BodyMotion {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d position;
  Eigen::Vector3d velocity, angular_velocity;
  Eigen::Vector3d acceleration, angular_acceleration;  // without the joints' own
};

// Motions of the bodies that moving joints carry; a joint's axis is the third column of its
// rotation.
using BodyMotions = std::array<BodyMotion, kMaxJoints>;
void body_motions(const Chain& chain, const double* q, const double* qd, BodyMotions& bodies);

BodyMotion frame_motion(const BodyMotions& bodies, const Frame& frame);

using FrameJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxJoints>;

// Linear rows first, one column a joint of the chain.
FrameJacobian frame_jacobian(const Chain& chain, const BodyMotions& bodies, const Frame& frame);

}  // namespace leadthrough
