#pragma once

// Sampled rotations as curves: the continuous logarithm, its Jacobian and the integral of an
// angular velocity. Angular velocities are in the base frame: dR/dt = [omega]x R.

#include "leadthrough/rotation/so3.hpp"

namespace leadthrough::so3 {

constexpr Eigen::Index kNowhere = -1;

struct Lifted {
  Vectors vectors;      // complete only if nothing is broken
  Eigen::Index broken;  // the first row that continues no logarithm, or kNowhere
};

// One logarithm a row, the first at most pi long, each continuing the one before it: of the
// vectors of the row's rotation, the one reached by the shortest rotation from the row before.
Lifted lift(const Rows4Ref& quaternions);

// Slerp through samples at increasing times, continuous in sign: one row per time between the first
// and the last; exact at the samples' own times.
Quaternions slerp_through(const VectorRef& times, const Rows4Ref& samples, const VectorRef& at);

// Of the rotation vectors of a unit quaternion, which lie `period` apart on one line, the nearest
// to `near`. Period 4 pi: of q in the double cover, since those between belong to -q. 2 pi: of the
// rotation, for w not negative.
Vector3 nearest_log(const Quaternion& q, const Vector3& near, double period);

// omega = J d(phi)/dt for the rotation exp(phi) (Sola et al. 2018, eqs. 145 and 146). The inverse
// does not exist where the angle is 2 pi n, n >= 1.
Matrix3 left_jacobian(const Vector3& rotation_vector);
Matrix3 left_jacobian_inverse(const Vector3& rotation_vector);
Matrices left_jacobian_batch(const Rows3Ref& rotation_vectors);
Matrices left_jacobian_inverse_batch(const Rows3Ref& rotation_vectors);

// Rotations at the times of the velocities, from `start` on: each step rotates by the mean of the
// velocities at its ends; second order in the step.
Quaternions integrate(const VectorRef& times, const Rows3Ref& angular_velocities,
                      const Eigen::Ref<const Quaternion>& start);

}  // namespace leadthrough::so3
