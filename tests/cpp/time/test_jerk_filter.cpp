#include <gtest/gtest.h>

#include <random>

#include "leadthrough/time/jerk_filter.hpp"

namespace leadthrough::jerk_filter_tests {

namespace {

Rows limits_of(Eigen::Index axes) {
  Rows limits(6, axes);
  for (Eigen::Index i = 0; i < axes; ++i) limits.col(i) << -1.0, 2.0, -3.0, 4.0, -30.0, 20.0;
  return limits;
}

Rows random_states(Eigen::Index axes) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  Rows states(3, axes);
  for (Eigen::Index i = 0; i < axes; ++i)
    states.col(i) << 3.0 * share(random), 0.5 * share(random), share(random);
  return states;
}

}  // namespace

TEST(JerkFilter, AMoveFromRestTakesTheTimeOfTheBooks) {
  Rows limits(6, 1), state(3, 1);
  limits << -1.0, 1.0, -2.0, 2.0, -10.0, 10.0;
  state << 0.5, 0.0, 0.0;
  const Eigen::VectorXd target = Eigen::VectorXd::Constant(1, 2.5);
  EXPECT_NEAR(times_to_rest(state, limits, target)[0], 2.0 / 1.0 + 1.0 / 2.0 + 2.0 / 10.0, 1e-12);
}

TEST(JerkFilter, TimesFallByThePeriodUntilAllRest) {
  const Eigen::Index axes = 200;
  const double period = 0.01;
  const Rows limits = limits_of(axes);
  Rows states = random_states(axes);
  const Eigen::VectorXd targets = Eigen::VectorXd::LinSpaced(axes, -2.0, 2.0);
  Eigen::VectorXd left = times_to_rest(states, limits, targets);
  for (int k = 0; k < 1000 && left.maxCoeff() > 0.0; ++k) {
    states = step_each(states, limits, targets, period);
    const Eigen::VectorXd next = times_to_rest(states, limits, targets);
    // The last of a way is as the third power of its time: rounding shows as a third root.
    EXPECT_LT((next - (left.array() - period).max(0.0).matrix()).cwiseAbs().maxCoeff(), 1e-3);
    left = next;
  }
  EXPECT_EQ(states.row(0), targets.transpose());
  EXPECT_TRUE(states.bottomRows(2).isZero(0.0));
}

TEST(JerkFilter, TogetherAllRestInTheSamePeriod) {
  const Eigen::Index axes = 20;
  const Rows limits = limits_of(axes);
  Rows states = random_states(axes);
  const Eigen::VectorXd targets = Eigen::VectorXd::LinSpaced(axes, -2.0, 2.0);
  Eigen::Index there = 0;
  for (int k = 0; k < 2000 && there == 0; ++k) {
    states = step_together(states, limits, targets, 0.01);
    there = (states.row(0).transpose().array() == targets.array()).count();
  }
  EXPECT_EQ(there, axes);
  EXPECT_TRUE(states.bottomRows(2).isZero(0.0));
}

TEST(JerkFilter, OneAloneIsNotHeldUpByTheOthers) {
  for (Eigen::Index i = 0; i < 20; ++i) {
    const Rows limits = limits_of(1), state = random_states(20).col(i);
    const Eigen::VectorXd target = Eigen::VectorXd::Constant(1, 1.0);
    const Rows alone = step_each(state, limits, target, 0.01);
    EXPECT_LT((step_together(state, limits, target, 0.01) - alone).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(JerkFilter, AStopEndsWhereItIsSaidTo) {
  const Rows limits = limits_of(5);
  Rows states = random_states(5);
  const Eigen::VectorXd places = resting_places(states, limits);
  for (int k = 0; k < 300; ++k) states = step_each(states, limits, places, 0.01);
  EXPECT_LT((states.row(0).transpose() - places).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace leadthrough::jerk_filter_tests
