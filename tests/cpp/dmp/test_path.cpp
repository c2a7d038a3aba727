#include <gtest/gtest.h>

#include <cmath>

#include "leadthrough/dmp/path.hpp"

namespace leadthrough::dmp::path_tests {

namespace {

double value_at(const Path& path, double phase) {
  const double* c = nullptr;
  const double s = place_in_piece(path, phase, &c);
  double result = 0.0;
  for (Eigen::Index power = 5; power >= 0; --power) result = result * s + c[power];
  return result;
}

Vector one(double value) { return Vector::Constant(1, value); }

TEST(Path, MinimumJerkGoesFromEndToEndAndRestsThere) {
  const Path path = minimum_jerk(one(1.0), one(3.0));
  EXPECT_DOUBLE_EQ(value_at(path, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(value_at(path, 0.5), 2.0);
  EXPECT_DOUBLE_EQ(value_at(path, 1.0), 3.0);
  EXPECT_DOUBLE_EQ(value_at(path, 7.0), 3.0);
  EXPECT_DOUBLE_EQ(end_of(path)[0], 3.0);
}

TEST(Path, CorrectionsAddUpAndLeaveNoJumpOfTheFirstTwoDerivatives) {
  Path path = minimum_jerk(one(0.0), one(1.0));
  double shifts = 0.0;
  for (int i = 0; i < 300; ++i) {
    const double phase = 0.005 * i;
    const double until = phase < 0.8 ? 1.0 : 0.05 * std::ceil((phase + 0.2) / 0.05 - 1e-9);
    const Path after = superposed(path, {phase, until, one(0.0), one(0.0), one(1e-3)});
    for (const double ahead : {0.0, 1e-4, 2e-4})
      EXPECT_NEAR(value_at(after, phase + ahead), value_at(path, phase + ahead), 1e-10) << phase;
    shifts += 1e-3;
    EXPECT_NEAR(end_of(after)[0], 1.0 + shifts, 1e-9);
    EXPECT_LE(after.breaks.size(), 8);
    path = after;
  }
}

TEST(Path, WalksFindThePiecesThatAreLookedUp) {
  Path path{Vector(5), Rows::Random(24, 2)};
  path.breaks << 0.0, 0.2, 0.5, 0.9, 1.0;
  Walk walk(path);
  // On breaks and beside them, beyond the end, and back.
  for (const double phase : {0.0, 0.1, 0.2, 0.2, 0.95, 1.0, 3.0, 0.3, 0.5, 0.05, 0.9, 0.1}) {
    const double *wanted = nullptr, *found = nullptr;
    EXPECT_EQ(walk.place_in_piece(phase, &found), place_in_piece(path, phase, &wanted)) << phase;
    EXPECT_EQ(found, wanted) << phase;
  }
}

TEST(Path, ShiftsComeAsFarAsTheProgressHas) {
  Path path = minimum_jerk(one(1.0), one(3.0));
  path = superposed(path, {0.25, 1.0, one(0.0), one(0.0), one(0.5)});
  const Path progress =
      superposed(minimum_jerk(one(0.0), one(1.0)), {0.25, 1.0, one(0.0), one(0.0), one(0.0)});
  ASSERT_EQ(path.breaks, progress.breaks);
  const Path found = shifted(path, progress.coefficients, one(-2.0), one(5.0));
  for (const double phase : {0.25, 0.4, 0.77, 1.0, 2.0}) {
    const double c = value_at(progress, phase);
    EXPECT_NEAR(value_at(found, phase), value_at(path, phase) - 2.0 * (1.0 - c) + 5.0 * c, 1e-12);
  }
}

TEST(Path, CorrectionBeginsWithItsValueAndSlope) {
  const Path path = superposed({}, {0.25, 0.75, one(0.5), one(-2.0), one(1.5)});
  EXPECT_DOUBLE_EQ(value_at(path, 0.25), 0.5);
  EXPECT_NEAR((value_at(path, 0.25 + 1e-6) - 0.5) / 1e-6, -2.0, 1e-4);
  EXPECT_NEAR(value_at(path, 0.75), 1.5, 1e-12);
  EXPECT_NEAR(value_at(path, 0.75 - 1e-5), 1.5, 1e-9);
}

}  // namespace

}  // namespace leadthrough::dmp::path_tests
