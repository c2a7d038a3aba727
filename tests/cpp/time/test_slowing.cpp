#include <gtest/gtest.h>

#include <cmath>

#include "leadthrough/time/slowing.hpp"

namespace leadthrough::slowing_tests {

namespace {

// The largest second difference, the arm at rest at both ends.
double largest_acceleration(const Eigen::VectorXd& times, const Rows& q) {
  const Eigen::Index last = times.size() - 1;
  Eigen::RowVectorXd velocity = Eigen::RowVectorXd::Zero(q.cols());
  double before = times[1] - times[0], largest = 0.0;
  for (Eigen::Index k = 0; k <= last; ++k) {
    const double after = k < last ? times[k + 1] - times[k] : before;
    Eigen::RowVectorXd next = Eigen::RowVectorXd::Zero(q.cols());
    if (k < last) next = (q.row(k + 1) - q.row(k)) / after;
    largest = std::max(largest, (next - velocity).cwiseAbs().maxCoeff() * 2.0 / (before + after));
    velocity = next;
    before = after;
  }
  return largest;
}

}  // namespace

TEST(Slowing, ALineIsRunInTheTimeOfTheTrapezoid) {
  const int samples = 2001;
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(samples, 5.0, 5.1);
  const Rows q = Eigen::VectorXd::LinSpaced(samples, 0.0, 1.0);
  const Slowing slowing =
      slow_down(times, q, Eigen::VectorXd::Constant(1, 1.0), Eigen::VectorXd::Constant(1, 4.0));
  EXPECT_EQ(slowing.stuck, -1);
  EXPECT_EQ(slowing.times[0], 5.0);
  EXPECT_NEAR(slowing.times[samples - 1] - 5.0, 1.0 / 1.0 + 1.0 / 4.0, 0.01);
  EXPECT_LE(largest_acceleration(slowing.times, q), 4.0 * (1.0 + 1e-9));
}

TEST(Slowing, ASlowMotionKeepsItsTimes) {
  const int samples = 200;
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(samples, 0.0, 10.0);
  Rows q(samples, 2);
  for (int k = 0; k < samples; ++k) {
    const double s = static_cast<double>(k) / (samples - 1);
    q.row(k) << s * s * (3.0 - 2.0 * s), 0.0;
  }
  const Eigen::VectorXd limit = Eigen::VectorXd::Constant(2, 2.0);
  const Slowing slowing = slow_down(times, q, limit, limit);
  EXPECT_LE((slowing.times - times).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Slowing, CornersAndPausesKeepTheLimits) {
  const int samples = 240;
  Eigen::VectorXd times(samples);
  Rows q(samples, 3);
  for (int k = 0; k < samples; ++k) {
    times[k] = 0.01 * k + 0.003 * std::sin(1.3 * k);
    const int clock = k / 40 % 2 == 0 ? k % 40 : 40;  // runs, then waits, then jumps back
    q.row(k) << 0.02 * clock, std::sin(0.3 * k), 0.1 * (k % 7);
  }
  const Eigen::VectorXd limit = Eigen::VectorXd::Constant(3, 2.0);
  const Slowing slowing = slow_down(times, q, limit, 3.0 * limit);
  for (Eigen::Index k = 1; k < samples; ++k) {
    const double duration = slowing.times[k] - slowing.times[k - 1];
    EXPECT_GE(duration, (times[k] - times[k - 1]) * (1.0 - 1e-9));
    EXPECT_LE((q.row(k) - q.row(k - 1)).cwiseAbs().maxCoeff() / duration, 2.0 * (1.0 + 1e-9));
  }
  EXPECT_LE(largest_acceleration(slowing.times, q), 6.0 * (1.0 + 1e-9));
}

TEST(Slowing, AJointThatMustNotMoveIsNamed) {
  Eigen::VectorXd times(2), velocity(2), acceleration(2);
  times << 0.0, 1.0;
  velocity << 1.0, 0.0;
  acceleration << 1.0, 1.0;
  Rows q(2, 2);
  q << 0.0, 0.0, 0.1, 0.1;
  EXPECT_EQ(slow_down(times, q, velocity, acceleration).stuck, 1);
  EXPECT_EQ(slow_down(times.head(1), q.topRows(1), velocity, acceleration).stuck, -1);
}

}  // namespace leadthrough::slowing_tests
