#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "leadthrough/guard/brake.hpp"

namespace leadthrough::brake_tests {

namespace {

constexpr Eigen::Index kJoints = 7;
constexpr double kRounding = 1e-12;

guard::StepLimits limits_of(double step, double bend, double twist) {
  const auto all = [](double value) { return Eigen::VectorXd::Constant(kJoints, value); };
  return {all(-10.0), all(10.0), all(step), all(bend), all(twist)};
}

Rows history_of(const Eigen::VectorXd& velocity, const Eigen::VectorXd& acceleration) {
  Rows rows = Rows::Zero(guard::kHistory, kJoints);
  rows.row(1) = rows.row(2) - velocity.transpose();
  rows.row(0) = rows.row(1) - (velocity - acceleration).transpose();
  return rows;
}

Rows with_rest(const Rows& history, const Rows& stop) {
  Rows rows(history.rows() + stop.rows() + guard::kHistory, history.cols());
  rows << history, stop, (stop.rows() ? stop : history).bottomRows(1).replicate(guard::kHistory, 1);
  return rows;
}

Rows difference(const Rows& rows) {
  return rows.bottomRows(rows.rows() - 1) - rows.topRows(rows.rows() - 1);
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
    const Rows history = history_of(velocity, acceleration);
    const Rows stop = guard::brake(limits, history);
    const Rows first = difference(with_rest(history, stop));
    const Rows second = difference(first), third = difference(second);
    EXPECT_LE(second.cwiseAbs().maxCoeff(), bend + kRounding);
    EXPECT_LE(third.cwiseAbs().maxCoeff(), twist + kRounding);
    EXPECT_LE(first.bottomRows(guard::kHistory).cwiseAbs().maxCoeff(), kRounding);
    int fewest = 0;
    for (Eigen::Index j = 0; j < kJoints; ++j)
      fewest = std::max(fewest, fewest_steps(velocity[j], acceleration[j], bend, twist));
    EXPECT_EQ(stop.rows(), fewest);
  }
}

// Jerk that binds all the time, some of it, and never.
INSTANTIATE_TEST_SUITE_P(Jerks, BrakeTest, testing::Values(1e-4, 2e-3, 0.1));

TEST(BrakeTest, NothingIsLeftToDoAtRest) {
  const Rows history = Rows::Constant(guard::kHistory, kJoints, 0.3);
  EXPECT_EQ(guard::brake(limits_of(0.04, 0.006, 1e-3), history).rows(), 0);
}

TEST(BrakeTest, WhereItRestsChangesSmoothlyWithTheVelocity) {
  const guard::StepLimits limits = limits_of(0.04, 0.006, 5e-4);
  const Eigen::VectorXd acceleration = Eigen::VectorXd::Constant(kJoints, 1e-3);
  double last = 0.0;
  for (int i = 0; i <= 4000; ++i) {
    const double velocity = 0.04 * i / 4000.0;
    const Rows history = history_of(Eigen::VectorXd::Constant(kJoints, velocity), acceleration);
    const Rows stop = guard::brake(limits, history);
    const double rest = stop(stop.rows() - 1, 0);
    if (i > 0) {
      EXPECT_LT(std::abs(rest - last), 1e-3);
    }
    last = rest;
  }
}

}  // namespace

}  // namespace leadthrough::brake_tests
