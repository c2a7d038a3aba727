#pragma once

// Orientations of a pose primitive. Three of its channels are coordinates e of a rotation relative
// to a curve G that follows the demonstration; an offset rotates both:
//
//   q(u) = exp(offset(u)) G(c(u)) E(e)
//
// The offset is a path of rotation vectors in the base frame; an empty one is the identity. G is a
// cumulative cubic B-spline (Kim, Kim and Shin 1995, "A general construction scheme for unit
// quaternion curves with simple high order derivatives"), C2 in c.

#include "leadthrough/dmp/primitive.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace leadthrough::dmp {

enum class Representation { kRotationVector, kZyz };  // E: the exponential, or three Euler angles

struct Curve {
  so3::Quaternions controls;  // (intervals + 3); interval i of c runs between controls i + 1, i + 2
  so3::Vectors steps;         // (intervals + 2), rotation vectors between neighbours, body frame
  Vector speeds;              // (m + 1), dc/du >= 0 at even phases, linear between them
  Vector covered;             // (m + 1), c there: the speeds' integral, from 0 to `intervals`
  Representation representation;
  Canonical canonical;
};

// True if a path is one of rotation vectors.
inline bool is_offset(const Path& path) { return path.empty() || path.coefficients.cols() == 3; }

// The rotation vector from `demonstrated` to `wanted`: of those, 2 pi apart on a line, the one
// nearest to `near`; with `near` = 0, the shortest. At pi the axis is the one whose first nonzero
// coordinate is positive.
so3::Vector3 offset_between(const so3::Quaternion& wanted, const so3::Quaternion& demonstrated,
                            const so3::Vector3& near);

so3::Quaternion orientation_at(const Curve& curve, const Path& offset, double phase,
                               const so3::Vector3& value);

// A rotation and its angular velocity in the base frame, per unit of phase.
struct RotationState {
  so3::Quaternion orientation;
  so3::Vector3 velocity;
};

RotationState rotation_at(const Curve& curve, const Path& offset, double phase,
                          const so3::Vector3& value, const so3::Vector3& slope);

// Coordinates of a rotation state; of the rotation's logarithms the one nearest to `near`.
struct Coordinates {
  so3::Vector3 value, slope;
};
Coordinates coordinates_of(const Curve& curve, const Path& offset, double phase,
                           const RotationState& state, const so3::Vector3& near);

// The acceleration of the coordinates due to an angular acceleration in the base frame.
so3::Vector3 coordinate_push(const Curve& curve, const Path& offset, double phase,
                             const so3::Vector3& value, const so3::Vector3& angular);

// One row a phase, sign-continuous. The last three columns of the values are the coordinates.
so3::Quaternions orientations_at(const Curve& curve, const Path& offset, const VectorRef& phases,
                                 const RowsRef& values);

// A motion of poses at increasing phases, from a state at the first of them on, without the rest
// of a rollout: on long motions allocating it takes longer than computing it.
struct Poses {
  Rows3 positions;
  so3::Quaternions orientations;  // sign-continuous
};
Poses poses_along(const Forces& forces, const Course& course, const Curve& curve,
                  const Path& offset, const State& state, const VectorRef& phases);

// The highest speeds of a motion rolled out at evenly spaced phases from 0 to 1, per unit of phase.
struct Peaks {
  double linear = 0.0, angular = 0.0;
};
Peaks peak_speeds(const Curve& curve, const Path& offset, const VectorRef& phases,
                  const Rollout& motion);

}  // namespace leadthrough::dmp
