#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/rotation/curve.hpp"

namespace leadthrough::curve_tests {

using so3::Matrix3;
using so3::Quaternion;
using so3::Vector3;

namespace {

const Vector3 kAxis(0.48, -0.6, 0.64);

so3::Quaternions spin(double to, int samples) {
  so3::Quaternions q(samples, 4);
  for (int i = 0; i < samples; ++i) q.row(i) = so3::exp(to * i / (samples - 1) * kAxis);
  return q;
}

}  // namespace

TEST(So3Curve, CurveThroughSamplesIsTheSlerpBetweenEachTwo) {
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(5, 1.0, 3.0);
  const so3::Quaternions samples = spin(2.6 * kPi, 5);  // 117 degrees from each to the next
  const Eigen::VectorXd at = Eigen::VectorXd::LinSpaced(101, 1.0, 3.0);
  const so3::Quaternions curve = so3::slerp_through(times, samples, at);
  for (Eigen::Index i = 0; i < at.size(); ++i)
    EXPECT_LT(so3::distance(Quaternion(curve.row(i)), so3::exp(1.3 * kPi * (at[i] - 1.0) * kAxis)),
              1e-14);
}

TEST(So3Curve, LiftKeepsTurnsWhateverTheSigns) {
  so3::Quaternions q = spin(-9.0 * kPi, 200);
  for (int i = 0; i < 200; i += 3) q.row(i) *= -1.0;
  const so3::Lifted lifted = so3::lift(q);
  ASSERT_EQ(lifted.broken, so3::kNowhere);
  EXPECT_LE((Vector3(lifted.vectors.row(199)) + 9.0 * kPi * kAxis).norm(), 1e-13);
}

TEST(So3Curve, LiftStopsWhereTheAxisSwings) {
  so3::Quaternions q = spin(4.0 * kPi, 2000);
  const Quaternion tilt = so3::exp(0.01 * kAxis.unitOrthogonal());
  for (int i = 0; i < 2000; ++i) q.row(i) = so3::compose(tilt, Quaternion(q.row(i)));
  EXPECT_NEAR(static_cast<double>(so3::lift(q).broken), 1000.0, 100.0);
}

TEST(So3Curve, LiftStopsAtHalfATurn) { EXPECT_EQ(so3::lift(spin(2.0 * kPi, 3)).broken, 1); }

TEST(So3Curve, JacobianAndItsInverseNearEveryAngle) {
  for (const double angle :
       {0.0, 1e-320, 1e-9, 1.0, kPi, 2.0 * kPi - 1e-3, 2.0 * kPi + 1e-3, 50.0}) {
    const Vector3 vector = angle * kAxis;
    const Matrix3 product = so3::left_jacobian(vector) * so3::left_jacobian_inverse(vector);
    EXPECT_LE((product - Matrix3::Identity()).norm(), 1e-11) << angle;
    EXPECT_LE((so3::left_jacobian(vector) * kAxis - kAxis).norm(), 1e-15) << angle;
  }
}

TEST(So3Curve, IntegralOfAnEvenTurnIsExact) {
  const Eigen::Vector3d times(0.0, 0.5, 3.0);
  const so3::Vectors velocities = Eigen::Vector3d::Ones() * kAxis.transpose();
  const Quaternion start = so3::exp(Vector3(1.0, 0.0, 0.0));
  const so3::Quaternions q = so3::integrate(times, velocities, start);
  EXPECT_LE(so3::distance(q.row(2), so3::compose(so3::exp(3.0 * kAxis), start)), 1e-15);
}

TEST(So3Curve, NoSamplesGiveNone) {
  EXPECT_EQ(so3::lift(so3::Quaternions(0, 4)).vectors.rows(), 0);
  EXPECT_EQ(so3::integrate(Eigen::VectorXd(0), so3::Vectors(0, 3), Quaternion(1, 0, 0, 0)).rows(),
            0);
}

}  // namespace leadthrough::curve_tests
