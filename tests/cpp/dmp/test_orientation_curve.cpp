#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/dmp/orientation_curve.hpp"

namespace leadthrough::dmp::orientation_curve_tests {

namespace {

using so3::Quaternion;
using so3::Vector3;

// Two turns about an axis that changes, at even speed, in intervals of 30 degrees.
Curve winding(Representation representation, Canonical canonical = Canonical::kDiscrete) {
  constexpr Eigen::Index kIntervals = 24;
  Curve curve{so3::Quaternions(kIntervals + 3, 4),
              so3::Vectors(kIntervals + 2, 3),
              Vector::Constant(11, kIntervals),
              Vector::LinSpaced(11, 0.0, kIntervals),
              representation,
              canonical};
  Quaternion q(1.0, 0.0, 0.0, 0.0);
  for (Eigen::Index i = 0; i < kIntervals + 3; ++i) {
    curve.controls.row(i) = q;
    const double lean = 0.1 * static_cast<double>(i);
    const Vector3 step = kPi / 6.0 * Vector3(std::sin(lean), 0.0, std::cos(lean));
    if (i < kIntervals + 2) curve.steps.row(i) = step;
    q = so3::compose(q, so3::exp(step));
  }
  return curve;
}

const Vector3 kLast(-0.5, 1.0, 0.1);
const Path kOffset = minimum_jerk(Vector3(0.3, -0.2, 0.9), kLast);
const Vector3 kValue(0.3, 0.5, -0.2);
const Vector3 kSlope(1.0, -2.0, 0.5);

TEST(Turning, VelocityIsTheDerivativeOfTheOrientation) {
  for (const Representation representation :
       {Representation::kRotationVector, Representation::kZyz}) {
    const Curve curve = winding(representation);
    for (const double phase : {0.01, 0.37, 0.5, 0.93}) {
      constexpr double kStep = 1e-6;
      const RotationState state = rotation_at(curve, kOffset, phase, kValue, kSlope);
      const Quaternion before =
          orientation_at(curve, kOffset, phase - kStep, kValue - kStep * kSlope);
      const Quaternion after =
          orientation_at(curve, kOffset, phase + kStep, kValue + kStep * kSlope);
      const Vector3 rate = so3::log(so3::compose(after, so3::inverse(before))) / (2.0 * kStep);
      EXPECT_LT((rate - state.velocity).norm(), 1e-4) << phase;
    }
  }
}

TEST(Turning, CurveIsSmoothWhereItsPiecesJoin) {
  const Curve curve = winding(Representation::kRotationVector);
  const Vector3 zero = Vector3::Zero();
  for (int piece = 1; piece < 24; ++piece) {
    const double join = piece / 24.0;
    const auto velocity = [&](double phase) {
      return rotation_at(curve, kOffset, phase, zero, zero).velocity;
    };
    constexpr double kStep = 1e-5;
    EXPECT_LT((velocity(join + 1e-9) - velocity(join - 1e-9)).norm(), 1e-5);
    const Vector3 left = (velocity(join - 1e-9) - velocity(join - kStep)) / kStep;
    const Vector3 right = (velocity(join + kStep) - velocity(join + 1e-9)) / kStep;
    EXPECT_LT((left - right).norm(), 0.5);  // of accelerations in the hundreds
  }
}

TEST(Turning, CoordinatesComeBack) {
  for (const Representation representation :
       {Representation::kRotationVector, Representation::kZyz}) {
    const Curve curve = winding(representation);
    const RotationState state = rotation_at(curve, kOffset, 0.4, kValue, kSlope);
    const Coordinates back = coordinates_of(curve, kOffset, 0.4, state, kValue);
    EXPECT_LT((back.value - kValue).norm(), 1e-9);
    EXPECT_LT((back.slope - kSlope).norm(), 1e-8);
  }
}

TEST(Turning, NearestCoordinatesCountTurns) {
  const Curve curve = winding(Representation::kRotationVector);
  const Vector3 long_way = kValue * (1.0 + 4.0 * kPi / kValue.norm());
  const RotationState state = rotation_at(curve, kOffset, 0.4, kValue, kSlope);
  const Coordinates back = coordinates_of(curve, kOffset, 0.4, state, long_way);
  EXPECT_LT((back.value - long_way).norm(), 1e-9);
}

TEST(Turning, ShortAndLongCoordinatesAgreeWithTheExponential) {
  const Curve curve = winding(Representation::kRotationVector);
  const Path none;
  const Quaternion base = orientation_at(curve, none, 0.2, Vector3::Zero());
  for (const double angle : {0.0, 1e-9, 0.1, 0.529, 0.5291, 0.53, 2.0, 9.0}) {
    const Vector3 vector = angle * Vector3(2.0, -1.0, 2.0) / 3.0;
    const Quaternion q = orientation_at(curve, none, 0.2, vector);
    EXPECT_LT(so3::distance(q, so3::compose(base, so3::exp(vector))), 1e-15) << angle;
  }
}

// Four phases at a time, some by themselves, and some too long for the series.
TEST(Turning, ManyOrientationsAreThoseOfEachPhase) {
  for (const Representation representation :
       {Representation::kRotationVector, Representation::kZyz}) {
    const Curve curve = winding(representation);
    const Vector phases = Vector::LinSpaced(23, 0.0, 1.1);
    Rows values(23, 6);
    for (Eigen::Index n = 0; n < values.rows(); ++n)
      for (Eigen::Index k = 0; k < 6; ++k)
        values(n, k) = (n < 15 ? 0.1 : 0.9) * std::sin(static_cast<double>(n * k + k));
    for (const Path& offset : {Path{}, kOffset}) {
      const so3::Quaternions all = orientations_at(curve, offset, phases, values);
      for (Eigen::Index n = 0; n < values.rows(); ++n) {
        const Quaternion one = orientation_at(curve, offset, phases[n], values.row(n).tail<3>());
        const Quaternion found = all.row(n);
        EXPECT_TRUE(found == one || found == -one) << n;
        if (n > 0) {
          EXPECT_GE(all.row(n).dot(all.row(n - 1)), 0.0) << n;
        }
      }
    }
  }
}

TEST(Turning, PosesAreThoseOfARolloutAndItsOrientations) {
  const Curve curve = winding(Representation::kRotationVector);
  // More phases than are turned at a time, and a number that is no multiple of four.
  const Vector phases = Vector::LinSpaced(151, 0.0, 1.0);
  Forces forces{Rows(5, 6), Vector::Ones(5), 12.5, Canonical::kDiscrete};
  for (Eigen::Index i = 0; i < forces.nodes.size(); ++i)
    forces.nodes.data()[i] = 40.0 * std::sin(static_cast<double>(3 * i));
  const Course course{minimum_jerk(Vector::Zero(6), Vector::LinSpaced(6, -0.2, 0.5)),
                      Vector::Ones(6), Vector::Zero(6)};
  const State start{Vector::Constant(6, 0.1), Vector::Zero(6), 0.0};
  const Rollout motion = rollout(forces, course, start, phases);
  const Poses poses = poses_along(forces, course, curve, kOffset, start, phases);
  EXPECT_EQ(poses.positions, motion.values.leftCols(3));
  EXPECT_EQ(poses.orientations, orientations_at(curve, kOffset, phases, motion.values));
}

// However the signs of a quaternion and of rounding fall.
TEST(Turning, HalfATurnIsAboutTheAxisWhoseFirstCoordinateIsPositive) {
  const Quaternion shown(1.0, 0.0, 0.0, 0.0);
  for (const Vector3& axis : {Vector3(0.6, -0.8, 0.0), Vector3(0.0, 0.6, -0.8),
                              Vector3(0.0, 1.0, 0.0), Vector3(0.0, 0.0, 1.0)}) {
    for (const double side : {-1.0, 1.0}) {
      for (const double off : {-1e-16, 0.0, 1e-16}) {
        Quaternion wanted;
        wanted << off, side * axis + Vector3::Constant(off);
        const Vector3 offset = offset_between(wanted, shown, Vector3::Zero());
        EXPECT_LT((offset - kPi * axis).norm(), 1e-8);
      }
    }
  }
}

TEST(Turning, PeakSpeedsAreThoseOfDenseDifferences) {
  const Curve curve = winding(Representation::kRotationVector);
  const Vector phases = Vector::LinSpaced(2001, 0.0, 1.0);
  Rollout motion{Rows::Zero(2001, 6), Rows::Zero(2001, 6)};
  motion.slopes.row(700) << 3.0, 0.0, -4.0, 9.0, 9.0, 9.0;
  const Peaks peaks = peak_speeds(curve, Path{}, phases, motion);
  double fastest = 0.0;
  for (const double phase : phases) {
    const Vector3 zero = Vector3::Zero();
    fastest = std::max(fastest, rotation_at(curve, Path{}, phase, zero, zero).velocity.norm());
  }
  EXPECT_EQ(peaks.linear, 5.0);
  EXPECT_NEAR(peaks.angular, fastest, 1e-3);
}

TEST(Turning, StandsAfterTheEndOrGoesRoundAgain) {
  const Vector3 zero = Vector3::Zero();
  const Curve once = winding(Representation::kRotationVector);
  const RotationState end = rotation_at(once, kOffset, 1.0, zero, zero);
  const RotationState later = rotation_at(once, kOffset, 7.5, zero, zero);
  EXPECT_EQ(end.orientation, later.orientation);
  EXPECT_EQ(later.velocity, zero);
  const Curve round = winding(Representation::kRotationVector, Canonical::kRhythmic);
  const Path same = minimum_jerk(kLast, kLast);
  EXPECT_LT(so3::distance(orientation_at(round, same, 0.25, zero),
                          orientation_at(round, same, 3.25, zero)),
            1e-12);
}

}  // namespace

}  // namespace leadthrough::dmp::orientation_curve_tests
