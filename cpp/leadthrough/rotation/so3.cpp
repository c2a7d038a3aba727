#include "leadthrough/rotation/so3.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough::so3 {

namespace {

// sin(x)/x - (1 - x^2/6) is below 1 ulp under this; the quotient itself only fails at x = 0.
constexpr double kSeriesAngle = 1e-4;  // rad

}  // namespace

Quaternion exp(const Vector3& rotation_vector) {
  double half = 0.5 * rotation_vector.norm();
  if (!std::isfinite(half)) half = (0.5 * rotation_vector).stableNorm();  // the norm overflows
  const double scale =
      half < kSeriesAngle ? 0.5 * (1.0 - half * half / 6.0) : 0.5 * std::sin(half) / half;
  Quaternion q;
  q << std::cos(half), scale * rotation_vector;
  return q;
}

Vector3 log(const Quaternion& quaternion) {
  const Vector3 vector = quaternion.tail<3>();
  const double sine = vector.stableNorm();
  if (sine == 0.0) return Vector3::Zero();
  // q and -q are one rotation: the sign of w chooses the half angle of at most pi / 2.
  const double w = quaternion[0];
  const double half = std::atan2(sine, std::abs(w));
  return vector * ((w < 0.0 ? -2.0 : 2.0) * half / sine);
}

double distance(const Quaternion& a, const Quaternion& b) {
  const Quaternion difference = compose(inverse(a), b);
  return 2.0 * std::atan2(difference.tail<3>().stableNorm(), std::abs(difference[0]));
}

Quaternion slerp(const Quaternion& a, const Quaternion& b, double fraction) {
  return compose(a, exp(fraction * log(compose(inverse(a), b))));
}

Matrix3 to_matrix(const Quaternion& q) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  Matrix3 m;
  m << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return m;
}

// Shepperd 1978: divide by the largest of the four components, so that nothing cancels.
Quaternion from_matrix(const Matrix3& m) {
  Quaternion q;
  const double trace = m.trace();
  Eigen::Index i = 0;
  const double largest = m.diagonal().maxCoeff(&i);
  if (trace >= largest) {
    q << 1 + trace, m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1);
  } else {
    const Eigen::Index j = (i + 1) % 3;
    const Eigen::Index k = (i + 2) % 3;
    q[0] = m(k, j) - m(j, k);
    q[1 + i] = 1 + 2 * m(i, i) - trace;
    q[1 + j] = m(j, i) + m(i, j);
    q[1 + k] = m(k, i) + m(i, k);
  }
  q.normalize();
  return q[0] < 0.0 ? Quaternion(-q) : q;
}

namespace {

using ByRows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// A value a row.
template <typename Result, typename At>
Result each_row(Eigen::Index rows, const At& at) {
  Result result(rows, Result::ColsAtCompileTime);
  for (Eigen::Index i = 0; i < rows; ++i) {
    check_interrupt(i);
    result.row(i) = at(i);
  }
  return result;
}

}  // namespace

Quaternions exp_batch(const Rows3Ref& rotation_vectors) {
  return each_row<Quaternions>(rotation_vectors.rows(), [&](Eigen::Index i) {
    return exp(Vector3(rotation_vectors.row(i)));
  });
}

Vectors log_batch(const Rows4Ref& quaternions) {
  return each_row<Vectors>(quaternions.rows(),
                           [&](Eigen::Index i) { return log(Quaternion(quaternions.row(i))); });
}

Quaternions compose_batch(const Rows4Ref& a, const Rows4Ref& b) {
  check_argument(a.rows() == b.rows(), "b: expected as many rows as a");
  return each_row<Quaternions>(a.rows(), [&](Eigen::Index i) {
    return compose(Quaternion(a.row(i)), Quaternion(b.row(i)));
  });
}

Matrices to_matrix_batch(const Rows4Ref& quaternions) {
  return each_row<Matrices>(quaternions.rows(), [&](Eigen::Index i) {
    return Eigen::Matrix<double, 9, 1>(
        to_matrix(Quaternion(quaternions.row(i))).reshaped<Eigen::RowMajor>());
  });
}

Quaternions from_matrix_batch(const Eigen::Ref<const Matrices>& matrices) {
  return each_row<Quaternions>(matrices.rows(), [&](Eigen::Index i) {
    return from_matrix(Eigen::Map<const ByRows>(matrices.row(i).data()));
  });
}

Quaternions slerp_batch(const Rows4Ref& a, const Rows4Ref& b, const VectorRef& fractions) {
  check_argument(a.rows() == b.rows() && fractions.size() == a.rows(),
                 "b, fractions: expected as many rows as a");
  return each_row<Quaternions>(a.rows(), [&](Eigen::Index i) {
    return slerp(Quaternion(a.row(i)), Quaternion(b.row(i)), fractions[i]);
  });
}

Eigen::VectorXd distance_batch(const Rows4Ref& a, const Rows4Ref& b) {
  check_argument(a.rows() == b.rows(), "b: expected as many rows as a");
  return each_row<Eigen::VectorXd>(a.rows(), [&](Eigen::Index i) {
    return Eigen::Matrix<double, 1, 1>(distance(Quaternion(a.row(i)), Quaternion(b.row(i))));
  });
}

}  // namespace leadthrough::so3
