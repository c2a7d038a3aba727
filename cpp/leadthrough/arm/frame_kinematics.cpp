#include "leadthrough/arm/frame_kinematics.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "leadthrough/arm/run_down.hpp"

namespace leadthrough {

namespace {

// The motion of a point that `body` carries at `offset` from its origin.
BodyMotion carried(const BodyMotion& body, const Eigen::Vector3d& offset) {
  BodyMotion point = body;
  const Eigen::Vector3d sideways = body.angular_velocity.cross(offset);
  point.position += offset;
  point.velocity += sideways;
  point.acceleration +=
      body.angular_acceleration.cross(offset) + body.angular_velocity.cross(sideways);
  return point;
}

BodyMotion at_rest() {
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  return {Eigen::Matrix3d::Identity(), zero, zero, zero, zero, zero};
}

void turn(BodyMotion& body, double q, double qd) {
  const Eigen::Vector3d x = body.rotation.col(0);
  const Eigen::Vector3d spin = qd * body.rotation.col(2);
  body.rotation.col(0) = std::cos(q) * x + std::sin(q) * body.rotation.col(1);
  body.rotation.col(1) = std::cos(q) * body.rotation.col(1) - std::sin(q) * x;
  body.angular_acceleration += body.angular_velocity.cross(spin);
  body.angular_velocity += spin;
}

void slide(BodyMotion& body, double q, double qd) {
  const Eigen::Vector3d axis = body.rotation.col(2);
  body = carried(body, q * axis);
  body.velocity += qd * axis;
  body.acceleration += 2.0 * body.angular_velocity.cross(qd * axis);
}

}  // namespace

Frame tip_frame(const Chain& chain) { return {chain.moving, chain.fixed[moving_count(chain)]}; }

void body_motions(const Chain& chain, const double* q, const double* qd, BodyMotions& bodies) {
  MovingValues value_room, rate_room;
  const double* values = moving_values(chain, q, value_room);
  const double* rates = moving_rates(chain, qd, rate_room);
  BodyMotion body = at_rest();
  for (std::size_t k = 0; k < moving_count(chain); ++k) {
    body = carried(body, body.rotation * chain.fixed[k].position);
    body.rotation = (body.rotation * chain.fixed[k].rotation).eval();
    if (chain.prismatic[k])
      slide(body, values[k], rates[k]);
    else
      turn(body, values[k], rates[k]);
    bodies[k] = body;
  }
}

BodyMotion frame_motion(const BodyMotions& bodies, const Frame& frame) {
  const BodyMotion& body = bodies[static_cast<std::size_t>(frame.moving - 1)];
  BodyMotion motion = carried(body, body.rotation * frame.T_joint_frame.position);
  motion.rotation = (body.rotation * frame.T_joint_frame.rotation).eval();
  return motion;
}

FrameJacobian frame_jacobian(const Chain& chain, const BodyMotions& bodies, const Frame& frame) {
  FrameJacobian jacobian = FrameJacobian::Zero(6, chain.joints());
  const Eigen::Vector3d position = frame_motion(bodies, frame).position;
  for (std::size_t k = 0; k < static_cast<std::size_t>(frame.moving); ++k) {
    const Eigen::Vector3d axis = bodies[k].rotation.col(2);
    Vector6 column;
    if (chain.prismatic[k])
      column << axis, Eigen::Vector3d::Zero();
    else
      column << axis.cross(position - bodies[k].position), axis;
    jacobian.col(chain.drives[k].joint) += chain.drives[k].multiplier * column;
  }
  return jacobian;
}

}  // namespace leadthrough
