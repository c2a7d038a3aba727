#include "leadthrough/rotation/curve.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/base/polynomial.hpp"

namespace leadthrough::so3 {

namespace {

// Closer than this to a full revolution rounding decides the axis: the previous axis is used.
constexpr double kWholeTurn = 1e-11;  // sine of half the angle

// Near the spheres of angle 2 pi n a vector moves further than its rotation, without bound: by a
// factor of at most (angle / 2) / sin(angle / 2). Beyond this factor it says little of the motion.
constexpr double kMaxGain = 10.0;

// Largest change of the axis by rounding, near kWholeTurn.
constexpr double kAxisNoise = 1e-4;  // rad

// Two rotations whose distance is this close to pi have no unique shortest rotation between them.
constexpr double kHalfTurnMargin = 1e-6;  // rad

bool continues(const Vector3& previous, const Vector3& vector, double turn) {
  const double noise = kAxisNoise * vector.norm();
  return turn <= kPi - kHalfTurnMargin && (vector - previous).norm() <= kMaxGain * turn + noise;
}

// 1 along the axis; across it, `across` plus `turned` times a rotation by a right angle.
Matrix3 about_axis(const Vector3& axis, double across, double turned) {
  return across * Matrix3::Identity() + (1.0 - across) * axis * axis.transpose() +
         turned * skew(axis);
}

template <typename Jacobian>
Matrices rows_of(const Rows3Ref& rotation_vectors, Jacobian jacobian) {
  Matrices result(rotation_vectors.rows(), 9);
  for (Eigen::Index i = 0; i < rotation_vectors.rows(); ++i) {
    check_interrupt(i);
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> m =
        jacobian(Vector3(rotation_vectors.row(i)));
    result.row(i) = Eigen::Map<const Eigen::Matrix<double, 1, 9>>(m.data());
  }
  return result;
}

// Smallest arc, for equal quaternions: the great circle is a straight line there to 1e-13.
constexpr double kMinArc = 1e-6;  // rad

// A great circle between two quaternions of one hemisphere, seen from its middle.
struct GreatCircle {
  GreatCircle(const Quaternion& a, const Quaternion& b)
      : arc(std::max(2.0 * std::atan2((b - a).norm(), (b + a).norm()), kMinArc)),
        middle((a + b) / (2.0 * std::cos(0.5 * arc))),
        tangent((b - a) / (2.0 * std::sin(0.5 * arc))) {}

  Quaternion at(double fraction) const {
    const double angle = arc * (fraction - 0.5), square = angle * angle;
    return polynomial(kCosine, square) * middle + (angle * polynomial(kSinc, square)) * tangent;
  }

  double arc;
  Quaternion middle, tangent;
};

}  // namespace

Quaternions slerp_through(const VectorRef& times, const Rows4Ref& samples, const VectorRef& at) {
  check_argument(times.size() > 1 && samples.rows() == times.size(),
                 "samples: expected one at each of two times or more");
  const Eigen::Index last = times.size() - 2;
  const auto circle_of = [&](Eigen::Index i) {
    return GreatCircle(Quaternion(samples.row(i)), Quaternion(samples.row(i + 1)));
  };
  Quaternions result(at.size(), 4);
  Eigen::Index piece = 0;
  GreatCircle circle = circle_of(piece);
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    check_interrupt(i);
    const double t = at[i];
    if (t < times[piece] || (t >= times[piece + 1] && piece < last)) {
      const double* after = std::upper_bound(times.data(), times.data() + times.size(), t);
      piece = std::clamp<Eigen::Index>(after - times.data() - 1, 0, last);
      circle = circle_of(piece);
    }
    if (t == times[piece] || t == times[piece + 1])
      result.row(i) = samples.row(t == times[piece] ? piece : piece + 1);
    else
      result.row(i) = circle.at((t - times[piece]) / (times[piece + 1] - times[piece]));
  }
  return result;
}

Lifted lift(const Rows4Ref& quaternions) {
  Lifted result{Vectors(quaternions.rows(), 3), kNowhere};
  if (quaternions.rows() == 0) return result;
  Quaternion before = quaternions.row(0);
  if (before[0] < 0.0) before = -before;
  Vector3 previous = log(before);
  result.vectors.row(0) = previous;
  for (Eigen::Index i = 1; i < quaternions.rows(); ++i) {
    check_interrupt(i);
    Quaternion q = quaternions.row(i);
    if (q.dot(before) < 0.0) q = -q;
    const Vector3 vector = nearest_log(q, previous, 2.0 * kTurn);
    if (!continues(previous, vector, distance(before, q))) {
      result.broken = i;
      return result;
    }
    result.vectors.row(i) = vector;
    before = q;
    previous = vector;
  }
  return result;
}

Vector3 nearest_log(const Quaternion& q, const Vector3& near, double period) {
  const Vector3 vector = q.tail<3>();
  const double sine = vector.norm();
  if (sine < kWholeTurn) {
    const double length = near.norm();
    const double base = q[0] < 0.0 ? kTurn : 0.0;
    const double angle = base + period * std::rint((length - base) / period);
    return angle == 0.0 ? Vector3(2.0 * vector) : Vector3(near * (angle / length));
  }
  const Vector3 axis = vector / sine;
  const double angle = 2.0 * std::atan2(sine, q[0]);
  return axis * (angle + period * std::rint((axis.dot(near) - angle) / period));
}

Matrix3 left_jacobian(const Vector3& rotation_vector) {
  const Vector3 vector = 0.5 * rotation_vector;
  const double half = vector.stableNorm();
  if (half == 0.0) return Matrix3::Identity();
  const double sine = std::sin(half);
  return about_axis(vector / half, sine * std::cos(half) / half, sine * sine / half);
}

Matrix3 left_jacobian_inverse(const Vector3& rotation_vector) {
  const Vector3 vector = 0.5 * rotation_vector;
  const double half = vector.stableNorm();
  if (half == 0.0) return Matrix3::Identity();
  return about_axis(vector / half, half * std::cos(half) / std::sin(half), -half);
}

Matrices left_jacobian_batch(const Rows3Ref& rotation_vectors) {
  return rows_of(rotation_vectors, &left_jacobian);
}

Matrices left_jacobian_inverse_batch(const Rows3Ref& rotation_vectors) {
  return rows_of(rotation_vectors, &left_jacobian_inverse);
}

Quaternions integrate(const VectorRef& times, const Rows3Ref& angular_velocities,
                      const Eigen::Ref<const Quaternion>& start) {
  check_argument(angular_velocities.rows() == times.size(),
                 "angular_velocities: expected one at each time");
  Quaternions result(times.size(), 4);
  if (times.size() == 0) return result;
  Quaternion q = start;
  result.row(0) = q;
  for (Eigen::Index i = 1; i < times.size(); ++i) {
    check_interrupt(i);
    const Vector3 sum = angular_velocities.row(i - 1) + angular_velocities.row(i);
    q = compose(exp(0.5 * (times[i] - times[i - 1]) * sum), q).normalized();
    result.row(i) = q;
  }
  return result;
}

}  // namespace leadthrough::so3
