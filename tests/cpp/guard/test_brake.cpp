#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "leadthrough/guard/brake.hpp"

namespace leadthrough::brake_tests {

namespace {

constexpr Eigen::Index kJoints = 7;
constexpr double kRounding = 1e-12;

// Per period of 1 s.
guard::StepLimits limits_of(double velocity, double acceleration, double jerk) {
  const auto all = [](double value) { return Eigen::VectorXd::Constant(kJoints, value); };
  return {all(-10.0), all(10.0), all(velocity), all(acceleration), all(jerk), 1.0};
}

Rows start_of(const Eigen::VectorXd& velocity, const Eigen::VectorXd& acceleration) {
  Rows row(1, 3 * kJoints);
  row << Eigen::RowVectorXd::Zero(kJoints), velocity.transpose(), acceleration.transpose();
  return row;
}

Rows difference(const Rows& rows) {
  return rows.bottomRows(rows.rows() - 1) - rows.topRows(rows.rows() - 1);
}

// Simpson's rule integrates the quadratic velocities exactly.
void expect_integrated(const Rows& rows) {
  const Rows a = rows.rightCols(kJoints), v = rows.middleCols(kJoints, kJoints);
  const Rows change = difference(v), moved = difference(rows.leftCols(kJoints));
  for (Eigen::Index i = 0; i + 1 < rows.rows(); ++i)
    for (Eigen::Index j = 0; j < kJoints; ++j) {
      EXPECT_NEAR(change(i, j), 0.5 * (a(i, j) + a(i + 1, j)), kRounding);
      const double middle = v(i, j) + 0.375 * a(i, j) + 0.125 * a(i + 1, j);
      EXPECT_NEAR(moved(i, j), (v(i, j) + 4.0 * middle + v(i + 1, j)) / 6.0, kRounding);
    }
}

// The fewest steps to rest by the acceleration at every step that leaves the most of the sum to
// come: what can be reached in m steps is an interval, and its ends are found by walking from both
// ends.
int fewest_steps(double velocity, double acceleration, double bend, double twist) {
  for (int m = 0;; ++m) {
    double low = 0.0, high = 0.0;
    if (std::abs(acceleration) > (m + 1) * twist * (1.0 + 1e-9)) continue;
    for (int i = 1; i <= m; ++i) {
      const double end = (m + 1 - i) * twist;
      low += std::max({acceleration - i * twist, -bend, -end});
      high += std::min({acceleration + i * twist, bend, end});
    }
    if (low <= -velocity + kRounding && -velocity <= high + kRounding) return m;
  }
}

class BrakeTest : public testing::TestWithParam<double> {};

TEST_P(BrakeTest, RestsInsideTheLimitsInTheFewestSteps) {
  const double twist = GetParam(), bend = 0.006, step = 0.04;
  const guard::StepLimits limits = limits_of(step, bend, twist);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int trial = 0; trial < 500; ++trial) {
    const double size = trial % 5 == 0 ? 1e-3 : 1.0;
    const Eigen::VectorXd velocity =
        Eigen::VectorXd::NullaryExpr(kJoints, [&] { return size * step * unit(random); });
    const Eigen::VectorXd acceleration =
        Eigen::VectorXd::NullaryExpr(kJoints, [&] { return bend * unit(random); });
    const Rows start = start_of(velocity, acceleration);
    const Rows stop = guard::brake(limits, start);
    Rows rows(1 + stop.rows(), start.cols());
    rows << start, stop;
    expect_integrated(rows);
    const Rows second = rows.rightCols(kJoints);
    EXPECT_LE(second.cwiseAbs().maxCoeff(), bend + kRounding);
    EXPECT_LE(difference(second).cwiseAbs().maxCoeff(), twist + kRounding);
    EXPECT_EQ(stop.bottomRightCorner(1, 2 * kJoints).cwiseAbs().maxCoeff(), 0.0);
    int fewest = 0;
    for (Eigen::Index j = 0; j < kJoints; ++j)
      fewest = std::max(
          fewest, fewest_steps(velocity[j] + 0.5 * acceleration[j], acceleration[j], bend, twist));
    EXPECT_EQ(stop.rows(), fewest + 1);
  }
}

// Jerk that binds all the time, some of it, and never.
INSTANTIATE_TEST_SUITE_P(Jerks, BrakeTest, testing::Values(1e-4, 2e-3, 0.1));

TEST(BrakeTest, NothingIsLeftToDoAtRest) {
  Rows start = Rows::Zero(1, 3 * kJoints);
  start.leftCols(kJoints).setConstant(0.3);
  EXPECT_EQ(guard::brake(limits_of(0.04, 0.006, 1e-3), start).rows(), 0);
}

TEST(BrakeTest, WhereItRestsChangesSmoothlyWithTheVelocity) {
  const guard::StepLimits limits = limits_of(0.04, 0.006, 5e-4);
  const Eigen::VectorXd acceleration = Eigen::VectorXd::Constant(kJoints, 1e-3);
  double last = 0.0;
  for (int i = 0; i <= 4000; ++i) {
    const double velocity = 0.04 * i / 4000.0;
    const Rows start = start_of(Eigen::VectorXd::Constant(kJoints, velocity), acceleration);
    const Rows stop = guard::brake(limits, start);
    const double rest = stop(stop.rows() - 1, 0);
    if (i > 0) {
      EXPECT_LT(std::abs(rest - last), 1e-3);
    }
    last = rest;
  }
}

}  // namespace

}  // namespace leadthrough::brake_tests
