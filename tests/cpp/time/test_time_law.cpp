#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/time/line_law.hpp"
#include "leadthrough/time/quintic_step.hpp"
#include "leadthrough/time/time_law.hpp"

namespace leadthrough::time_law_tests {

namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

// A straight line of one joint, of length 1 over the parameter 0 to 1.
PolynomialPath line() { return {Eigen::Vector2d(0.0, 1.0), Eigen::Vector2d(0.0, 1.0)}; }

// Two joints around a bend, smooth and of changing pace.
PolynomialPath bend() {
  PolynomialPath path{Eigen::Vector2d(0.0, 1.0), Rows(5, 2)};
  path.coefficients << 0.0, 0.0, 0.3, 0.1, 1.5, -1.0, -0.4, 2.0, 0.2, -0.5;
  return path;
}

PathBounds no_bounds(const PathGrid& grid) {
  const Rows none(grid.points(), 0);
  return {Eigen::VectorXd::Constant(grid.points(), kNone), none, none, none, none};
}

RateLimits limits(int joints, double velocity, double acceleration, double jerk) {
  return {Eigen::VectorXd::Constant(joints, velocity),
          Eigen::VectorXd::Constant(joints, acceleration), Eigen::VectorXd::Constant(joints, jerk)};
}

double largest_difference(const Rows& q, int order, double period) {
  Rows padded(q.rows() + 6, q.cols());
  padded << q.row(0).replicate(3, 1), q, q.row(q.rows() - 1).replicate(3, 1);
  for (int k = 0; k < order; ++k)
    padded = ((padded.bottomRows(padded.rows() - 1) - padded.topRows(padded.rows() - 1)) / period)
                 .eval();
  return padded.cwiseAbs().maxCoeff();
}

TEST(TimeLines, PointsAndCountsOfNoMotionAreRefused) {
  const RateLimits limits{Eigen::VectorXd::Ones(1), Eigen::VectorXd::Ones(1),
                          Eigen::VectorXd::Ones(1)};
  Rows points(2, 1);
  points << 0.0, std::nan("");
  EXPECT_THROW(time_lines(points, limits, 0.01, 1e7), std::invalid_argument);
  points << 0.0, 1e300;
  EXPECT_EQ(time_lines(points, limits, 0.01, 1e7).failed_at, 0);
  EXPECT_THROW(time_lines(points, limits, 0.01, kInfinity), std::invalid_argument);
}

}  // namespace

TEST(Reachability, RampsUpAndDownOnALine) {
  SpeedBounds bounds;
  bounds.grid = Eigen::VectorXd::LinSpaced(101, 0.0, 1.0);
  bounds.fastest = Eigen::VectorXd::Constant(101, 1.0);
  bounds.gain = Rows::Ones(101, 1);
  bounds.bend = Rows::Zero(101, 1);
  bounds.lower = Rows::Constant(101, 1, -2.0);
  bounds.upper = Rows::Constant(101, 1, 2.0);
  SpeedProfile profile;
  fastest_profile(bounds, 0.0, 0.0, profile);
  ASSERT_EQ(profile.status, SpeedStatus::kOk);
  for (Eigen::Index i = 0; i < 101; ++i) {
    const double s = bounds.grid[i];
    EXPECT_NEAR(profile.squared[i], std::min({1.0, 4.0 * s, 4.0 * (1.0 - s)}), 1e-9);
  }
}

TEST(Reachability, SaysWhereNoMotionIsPossible) {
  SpeedBounds bounds;
  bounds.grid = Eigen::VectorXd::LinSpaced(11, 0.0, 1.0);
  bounds.fastest = Eigen::VectorXd::Ones(11);
  bounds.gain = Rows::Ones(11, 1);
  bounds.bend = Rows::Zero(11, 1);
  bounds.lower = Rows::Constant(11, 1, -1.0);
  bounds.upper = Rows::Constant(11, 1, 1.0);
  SpeedProfile profile;
  fastest_profile(bounds, 0.0, 4.0, profile);
  EXPECT_EQ(profile.status, SpeedStatus::kEndTooFast);
  bounds.fastest.setConstant(9.0);
  fastest_profile(bounds, 0.0, 4.0, profile);
  EXPECT_EQ(profile.status, SpeedStatus::kStartTooFast);  // it can't get that fast: 2 at most
  fastest_profile(bounds, 2.0, 4.0, profile);
  EXPECT_EQ(profile.status, SpeedStatus::kOk);
  bounds.lower(5, 0) = 0.5;
  bounds.upper(5, 0) = 0.4;
  fastest_profile(bounds, 0.0, 0.0, profile);
  EXPECT_EQ(profile.status, SpeedStatus::kNoMotion);
}

TEST(Reachability, LeavesOutWhatDoesNotChange) {
  constexpr Eigen::Index kPoints = 300;
  SpeedBounds bounds;
  bounds.grid = Eigen::VectorXd::LinSpaced(kPoints, 0.0, 1.0);
  bounds.fastest = Eigen::VectorXd::Constant(kPoints, 2.0);
  bounds.gain = bounds.bend = Rows(kPoints, 2);
  for (Eigen::Index i = 0; i < kPoints; ++i) {
    const double s = bounds.grid[i];
    bounds.gain.row(i) << std::cos(9.0 * s), std::sin(7.0 * s);
    bounds.bend.row(i) << -9.0 * std::sin(9.0 * s), 7.0 * std::cos(7.0 * s);
  }
  bounds.lower = Rows::Constant(kPoints, 2, -3.0);
  bounds.upper = Rows::Constant(kPoints, 2, 3.0);
  SpeedProfile kept;
  fastest_profile(bounds, 0.0, 0.0, kept);
  for (Eigen::Index at = 0; at < kPoints; at += 23) {
    std::vector<char> changed(kPoints, 0);
    for (Eigen::Index i = at; i < std::min(at + 5, kPoints); ++i) {
      bounds.lower.row(i) *= 0.7;
      bounds.upper.row(i) *= 0.7;
      bounds.fastest[i] *= i % 2 == 0 ? 0.5 : 1.0;
      changed[static_cast<std::size_t>(i)] = 1;
    }
    SpeedProfile whole;
    fastest_profile(bounds, 0.0, 0.0, whole);
    fastest_profile(bounds, 0.0, 0.0, kept, changed);
    ASSERT_EQ(kept.status, SpeedStatus::kOk);
    EXPECT_EQ(kept.squared, whole.squared);
  }
}

TEST(TimeLaw, KeepsLimitsOnItsSamples) {
  for (const PolynomialPath& path : {line(), bend()}) {
    const auto joints = static_cast<int>(path.joints());
    const PathGrid grid = make_path_grid(path, Eigen::VectorXd::Ones(joints), 501);
    for (const double jerk : {kNone, 1000.0, 50.0, 5.0}) {
      const TimeLaw law =
          make_time_law(path, grid, limits(joints, 1.0, 3.0, jerk), no_bounds(grid));
      ASSERT_EQ(law.status, TimeLawStatus::kOk);
      const MotionStates motion = states_along(path, grid, law.length, law.speed, law.push);
      const Rows& q = motion.positions;
      const StepExtremes between = step_extremes(
          1e-3 * Eigen::VectorXd::LinSpaced(q.rows(), 0.0, static_cast<double>(q.rows() - 1)), q,
          motion.velocities, motion.accelerations);
      EXPECT_LE(between.speed.maxCoeff(), 1.0 + 1e-6);
      EXPECT_LE(between.acceleration.maxCoeff(), 3.0 * (1.0 + 1e-6));
      const Rows jerks = (motion.accelerations.bottomRows(q.rows() - 1) -
                          motion.accelerations.topRows(q.rows() - 1)) /
                         1e-3;
      EXPECT_LE(jerks.cwiseAbs().maxCoeff(), jerk * (1.0 + 1e-6));
      EXPECT_LE(largest_difference(q, 1, 1e-3), 1.0 + 1e-6);
      EXPECT_LE(largest_difference(q, 2, 1e-3), 3.0 + 1e-5);
      EXPECT_LE(largest_difference(q, 3, 1e-3), jerk * (1.0 + 1e-5));
      EXPECT_DOUBLE_EQ(law.length[0], 0.0);
      EXPECT_NEAR(law.length[law.length.size() - 1], grid.end(), 1e-12);
      EXPECT_NEAR(law.duration, 1e-3 * static_cast<double>(law.length.size() - 1), 1e-12);
    }
  }
}

TEST(TimeLaw, ReturnsItsOwnDerivatives) {
  const PolynomialPath path = bend();
  const PathGrid grid = make_path_grid(path, Eigen::VectorXd::Ones(2), 501);
  const TimeLaw law = make_time_law(path, grid, limits(2, 1.0, 3.0, 50.0), no_bounds(grid));
  ASSERT_EQ(law.status, TimeLawStatus::kOk);
  const Eigen::Index n = law.length.size() - 2;
  const Eigen::VectorXd speed = (law.length.tail(n) - law.length.head(n)) / 2e-3;
  const Eigen::VectorXd push = (law.speed.tail(n) - law.speed.head(n)) / 2e-3;
  EXPECT_LE((speed - law.speed.segment(1, n)).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_LE((push - law.push.segment(1, n)).cwiseAbs().maxCoeff(), 2e-2);
  EXPECT_EQ(law.speed[0], 0.0);
  EXPECT_EQ(law.push[n + 1], 0.0);
}

TEST(QuinticStep, FindsTheExtremesBetweenTheSamples) {
  // There and back: from rest at 0 with a push, through a peak in the middle.
  const QuinticStep bow(1.0, {0.0, 4.0, 0.0}, {0.0, -4.0, 0.0});
  EXPECT_NEAR(bow.highest().value, 1.25, 1e-12);
  EXPECT_NEAR(bow.highest().at, 0.5, 1e-9);
  EXPECT_EQ(bow.lowest().value, 0.0);
  EXPECT_EQ(bow.speed().value, 4.0);
  const QuinticStep rest(2.0, {0.0, 0.0, 0.0}, {1.0, 0.0, 0.0});  // the least jerk
  EXPECT_NEAR(rest.speed().value, 0.5 * 1.875, 1e-12);
  EXPECT_NEAR(rest.acceleration().value, 0.25 * 10.0 / std::sqrt(3.0), 1e-12);
}

TEST(TimeLaw, TakesALineInTheTimeOfATrapezoid) {
  const PolynomialPath path = line();
  const PathGrid grid = make_path_grid(path, Eigen::VectorXd::Ones(1), 1001);
  const TimeLaw law = make_time_law(path, grid, limits(1, 1.0, 4.0, kNone), no_bounds(grid));
  EXPECT_NEAR(law.optimum, 1.25, 1e-3);
  EXPECT_NEAR(law.duration, 1.25, 4e-3);
}

TEST(TimeLaw, IsTheSameForAnyPaceOfThePathsParameter) {
  PolynomialPath path = bend(), slow = path;
  slow.breaks *= 10.0;
  for (Eigen::Index k = 0; k < 5; ++k) slow.coefficients.row(k) /= std::pow(10.0, k);
  Eigen::VectorXd durations(2);
  Eigen::Index i = 0;
  for (const PolynomialPath* one : {&path, &slow}) {
    const PathGrid grid = make_path_grid(*one, Eigen::VectorXd::Ones(2), 501);
    durations[i++] = make_time_law(*one, grid, limits(2, 1.0, 3.0, 50.0), no_bounds(grid)).duration;
  }
  EXPECT_NEAR(durations[0], durations[1], 1e-9);
}

}  // namespace leadthrough::time_law_tests
