#include <gtest/gtest.h>

#include <cmath>

#include "leadthrough/guard/bridge.hpp"
#include "leadthrough/guard/pace.hpp"
#include "leadthrough/guard/path_curve.hpp"

namespace leadthrough::pace_tests {

namespace {

constexpr Eigen::Index kSamples = 60;

// Per period of 1 s.
guard::StepLimits limits_of(double velocity, double acceleration, double jerk) {
  const auto all = [](double value) { return Eigen::VectorXd::Constant(2, value); };
  return {all(-10.0), all(10.0), all(velocity), all(acceleration), all(jerk), 1.0};
}

// A circle, a round in so many samples.
Rows circle(double samples) {
  Rows rows(kSamples, 6);
  const double rate = 2.0 * M_PI / samples;
  for (Eigen::Index i = 0; i < kSamples; ++i) {
    const double angle = rate * static_cast<double>(i), c = std::cos(angle), s = std::sin(angle);
    rows.row(i) << c, s, -rate * s, rate * c, -rate * rate * c, -rate * rate * s;
  }
  return rows;
}

double radius(const Rows& rows, Eigen::Index k) { return rows.row(k).head(2).norm(); }

TEST(PathCurveTest, RatesOfSamplesOfAParabolaAreItsOwn) {
  Eigen::VectorXd times(5);
  times << 0.0, 0.5, 0.7, 1.6, 2.0;
  const Eigen::VectorXd q = 1.0 + 0.5 * times.array() - 2.0 * times.array().square();
  const Rows none(0, 3);
  const Rows states = guard::with_rates(times, q, none, 1.0);
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    EXPECT_NEAR(states(i, 1), 0.5 - 4.0 * times[i], 1e-12);
    EXPECT_NEAR(states(i, 2), -4.0, 1e-12);
  }
  const Rows next = guard::with_rates(times.head(1), q.tail(1), states.row(3), 0.4);
  EXPECT_NEAR((next - states.row(4)).norm(), 0.0, 1e-12);
}

TEST(PathCurveTest, ItRunsAtAnyPaceWithTheRatesOfFiniteDifferences) {
  const Rows path = circle(20.0);
  const guard::PathCurve curve(path, 1.0);
  const auto place = [](double t) { return 7.3 + 0.4 * t + 0.1 * t * t; };
  const auto at = [&](double t) {
    Eigen::RowVectorXd row(6);
    curve.at(place(t), 0.4 + 0.2 * t, 0.2, Eigen::Ref<Eigen::RowVectorXd>(row));
    return row;
  };
  const double h = 1e-4;
  const Eigen::RowVectorXd before = at(-h), here = at(0.0), after = at(h);
  EXPECT_LT(((after - before).head(4) / (2.0 * h) - here.tail(4)).norm(), 1e-6);
}

TEST(PaceTest, APathThatKeepsItsLimitsStaysAsItIsToTheBit) {
  const Rows path = circle(60.0);
  const auto found = guard::slowed(limits_of(0.2, 0.05, 0.05), path, 1000);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->samples, path);
}

TEST(PaceTest, ASlowedPathStaysOnItsCurveAndEndsWhereItEnds) {
  const Rows path = circle(60.0);
  const guard::StepLimits limits = limits_of(0.05, 0.05, 0.05);
  const auto found = guard::slowed(limits, path, 1000);
  ASSERT_TRUE(found);
  const Rows& samples = found->samples;
  EXPECT_FALSE(
      guard::first_excess(limits, samples.topRows(1), samples.bottomRows(samples.rows() - 1)));
  EXPECT_EQ(samples.row(0).head(2), path.row(0).head(2));
  EXPECT_LT((samples.bottomRows(1) - path.bottomRows(1)).leftCols(2).norm(), 1e-12);
  for (Eigen::Index k = 0; k < samples.rows(); ++k) EXPECT_NEAR(radius(samples, k), 1.0, 1e-3);
  // A round of length 2 pi at 0.05 a sample takes 126 samples; 59 of 60 parts of it 124.
  EXPECT_LT(samples.rows(), 135);
}

TEST(PaceTest, AStopKeepsThePathAndRestsOnIt) {
  const Rows path = circle(60.0);
  const guard::StepLimits limits = limits_of(0.2, 0.05, 0.05);
  const auto found = guard::stopped(limits, path.topRows(1), path.middleRows(1, 40));
  ASSERT_TRUE(found);
  const Rows& samples = found->samples;
  for (Eigen::Index k = 0; k < samples.rows(); ++k) EXPECT_NEAR(radius(samples, k), 1.0, 1e-3);
  const Eigen::Index last = samples.rows() - 1;
  EXPECT_EQ(samples.row(last).tail(4).norm(), 0.0);
  EXPECT_EQ(samples.row(0), path.row(1));
  // As late as it can: it ends at the last row but one, or half a row behind it.
  EXPECT_NEAR(found->places.tail(1)[0], 38.25, 0.3);
}

TEST(BridgeTest, LeadsFromRestOntoAMovingCircleInsideTheLimits) {
  const Rows path = circle(60.0);
  const guard::StepLimits limits = limits_of(0.2, 0.05, 0.05);
  Rows start = Rows::Zero(1, 6);
  start.leftCols(2) << 0.5, -0.5;
  const auto late = guard::bridge_to_start(limits, start, path, 500);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->skipped, 0);
  Rows rows(late->samples.rows() + kSamples, 6);
  rows << late->samples, path;
  EXPECT_FALSE(guard::first_excess(limits, start, rows));
  const auto on_time = guard::bridge_on_time(limits, start, path, 500);
  ASSERT_TRUE(on_time);
  EXPECT_EQ(on_time->skipped, on_time->samples.rows());
}

TEST(BridgeTest, NoBridgeIsNeededOntoSamplesThatFollow) {
  const Rows path = circle(60.0);
  const auto found =
      guard::bridge_to_start(limits_of(0.2, 0.05, 0.05), path.topRows(1), path.bottomRows(59), 9);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->samples.rows(), 0);
}

}  // namespace

TEST(Pace, SamplesThatNoMemoryHoldsAreRefused) {
  for (const Eigen::Index most : {Eigen::Index{0}, guard::kMaxPaced + 1})
    EXPECT_THROW(guard::slowed(limits_of(1.0, 1.0, 1.0), circle(30.0), most),
                 std::invalid_argument);
}

}  // namespace leadthrough::pace_tests
