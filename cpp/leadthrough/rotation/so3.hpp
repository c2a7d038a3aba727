#pragma once

// Rotations as unit quaternions (w, x, y, z) and rotation vectors (axis times angle, rad).
// Exp and log after Sola, Deray, Atchuthan 2018, "A micro Lie theory", examples 3 and 4.

#include "leadthrough/base/matrix.hpp"

namespace leadthrough::so3 {

using Vector3 = Eigen::Vector3d;
using Quaternion = Eigen::Vector4d;  // w, x, y, z
using Matrix3 = Eigen::Matrix3d;

using Vectors = Rows3;
using Matrices = Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor>;
using Quaternions = Rows4;

// Unit quaternion of a rotation vector of any length.
Quaternion exp(const Vector3& rotation_vector);

// Rotation vector of length at most pi. The quaternion need not have unit length.
// At exactly pi, the sign of the quaternion selects one of the two opposite vectors.
Vector3 log(const Quaternion& quaternion);

// The rotation of b followed by that of a.
inline Quaternion compose(const Quaternion& a, const Quaternion& b) {
  return {a[0] * b[0] - (a[1] * b[1] + a[2] * b[2] + a[3] * b[3]),
          a[0] * b[1] + b[0] * a[1] + (a[2] * b[3] - a[3] * b[2]),
          a[0] * b[2] + b[0] * a[2] + (a[3] * b[1] - a[1] * b[3]),
          a[0] * b[3] + b[0] * a[3] + (a[1] * b[2] - a[2] * b[1])};
}

// The inverse of a unit quaternion.
inline Quaternion inverse(const Quaternion& quaternion) {
  return {quaternion[0], -quaternion[1], -quaternion[2], -quaternion[3]};
}

// The matrix of a cross product: skew(a) b = a x b.
inline Matrix3 skew(const Vector3& a) {
  Matrix3 m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

// Geodesic distance in rad, from 0 to pi, independent of the quaternions' signs.
double distance(const Quaternion& a, const Quaternion& b);

// From a by this fraction of the shortest rotation to b, in the hemisphere of a. Of the two
// rotations of exactly pi, the one to b with the sign as given.
Quaternion slerp(const Quaternion& a, const Quaternion& b, double fraction);

// Rotation matrix of a unit quaternion, and back.
Matrix3 to_matrix(const Quaternion& quaternion);
Quaternion from_matrix(const Matrix3& matrix);

// One row a rotation.
Quaternions exp_batch(const Rows3Ref& rotation_vectors);
Vectors log_batch(const Rows4Ref& quaternions);
Quaternions compose_batch(const Rows4Ref& a, const Rows4Ref& b);
// Nine numbers a row: the matrix, row by row.
Matrices to_matrix_batch(const Rows4Ref& quaternions);
Quaternions from_matrix_batch(const Eigen::Ref<const Matrices>& matrices);
Quaternions slerp_batch(const Rows4Ref& a, const Rows4Ref& b, const VectorRef& fractions);
Eigen::VectorXd distance_batch(const Rows4Ref& a, const Rows4Ref& b);

}  // namespace leadthrough::so3
