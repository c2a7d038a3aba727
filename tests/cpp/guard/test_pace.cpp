#include <gtest/gtest.h>

#include <cmath>

#include "leadthrough/guard/bridge.hpp"
#include "leadthrough/guard/pace.hpp"
#include "leadthrough/guard/path_curve.hpp"

namespace leadthrough::pace_tests {

namespace {

constexpr Eigen::Index kSamples = 60;

guard::StepLimits limits_of(double step, double bend, double twist) {
  const auto all = [](double value) { return Eigen::VectorXd::Constant(2, value); };
  return {all(-10.0), all(10.0), all(step), all(bend), all(twist)};
}

// A circle, a round in so many samples.
Rows circle(double samples) {
  Rows rows(kSamples, 2);
  for (Eigen::Index i = 0; i < kSamples; ++i) {
    const double angle = 2.0 * M_PI * static_cast<double>(i) / samples;
    rows.row(i) << std::cos(angle), std::sin(angle);
  }
  return rows;
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
      guard::first_excess(limits, samples.topRows(3), samples.bottomRows(samples.rows() - 3)));
  EXPECT_EQ(samples.row(0), path.row(0));
  EXPECT_LT((samples.bottomRows(1) - path.bottomRows(1)).norm(), 1e-12);
  for (Eigen::Index k = 0; k < samples.rows(); ++k) EXPECT_NEAR(samples.row(k).norm(), 1.0, 1e-3);
  // A round of length 2 pi at 0.05 a sample takes 126 samples; 59 of 60 parts of it 124.
  EXPECT_LT(samples.rows(), 135);
}

TEST(PaceTest, AStopKeepsThePathAndRestsOnIt) {
  const Rows path = circle(60.0);
  const guard::StepLimits limits = limits_of(0.2, 0.05, 0.05);
  const auto found = guard::stopped(limits, path.topRows(3), path.middleRows(3, 40));
  ASSERT_TRUE(found);
  const Rows& samples = found->samples;
  for (Eigen::Index k = 0; k < samples.rows(); ++k) EXPECT_NEAR(samples.row(k).norm(), 1.0, 1e-3);
  const Eigen::Index last = samples.rows() - 1;
  EXPECT_LT((samples.row(last) - samples.row(last - 1)).norm(), 0.05);
  EXPECT_EQ(samples.row(0), path.row(3));
  // As late as it can: it ends at the last row but one, or half a row behind it.
  EXPECT_NEAR(found->places.tail(1)[0], 38.25, 0.3);
}

TEST(BridgeTest, LeadsFromRestOntoAMovingCircleInsideTheLimits) {
  const Rows path = circle(60.0);
  const guard::StepLimits limits = limits_of(0.2, 0.05, 0.05);
  const Rows history = Eigen::RowVector2d(0.5, -0.5).replicate(3, 1);
  const auto late = guard::bridge_to_start(limits, history, path, 500);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->skipped, 0);
  Rows rows(late->samples.rows() + kSamples, 2);
  rows << late->samples, path;
  EXPECT_FALSE(guard::first_excess(limits, history, rows));
  const auto on_time = guard::bridge_on_time(limits, history, path, 500);
  ASSERT_TRUE(on_time);
  EXPECT_EQ(on_time->skipped, on_time->samples.rows());
}

TEST(BridgeTest, NoBridgeIsNeededOntoSamplesThatFollow) {
  const Rows path = circle(60.0);
  const auto found =
      guard::bridge_to_start(limits_of(0.2, 0.05, 0.05), path.topRows(3), path.bottomRows(57), 9);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->samples.rows(), 0);
}

}  // namespace

}  // namespace leadthrough::pace_tests
