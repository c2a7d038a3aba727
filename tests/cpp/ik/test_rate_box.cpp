#include <gtest/gtest.h>

#include <random>

#include "leadthrough/ik/rate_box.hpp"

namespace leadthrough::rate_box_tests {

// A joint that always drives on, at random intervals, at random towards either wall.
TEST(RateBox, IsNeverEmptyAndNeverLeadsBeyondAWall) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int run = 0; run < 200; ++run) {
    const JointRates limits{0.5 + 3.0 * uniform(generator), 1.0 + 20.0 * uniform(generator)};
    const double braking = 0.2 + 0.8 * uniform(generator);
    double q = 0.5, velocity = 0.0, before = 0.01, until = 3.0;
    for (int k = 0; k < 400; ++k) {
      const double duration = std::pow(10.0, -3.0 + 2.0 * uniform(generator));
      const double since = 0.5 * (before + duration);
      until -= since;
      if (until < 0.0) break;
      const double change = limits.acceleration * since * (1.0 + 1e-12);
      const Span span =
          allowed_velocities(limits, {duration, since, until}, {-q, 1.0 - q}, velocity, braking);
      ASSERT_LE(span.lower, span.upper);
      ASSERT_GE(span.upper, velocity - change - 1e-12);
      ASSERT_LE(span.lower, velocity + change + 1e-12);
      const double drive = uniform(generator) < 0.5 * (1.0 + std::sin(0.05 * k)) ? 1.0 : 0.0;
      velocity = span.lower + drive * (span.upper - span.lower);
      ASSERT_LE(std::abs(velocity), limits.velocity * (1.0 + 1e-12));
      q += velocity * duration;
      ASSERT_GE(q, -1e-9);
      ASSERT_LE(q, 1.0 + 1e-9);
      before = duration;
    }
  }
}

TEST(RateBox, WithoutLimitsTheWallIsTheOnlyBound) {
  const double none = std::numeric_limits<double>::infinity();
  const Span span = allowed_velocities({none, none}, {0.1, 0.1, 0.0}, {-none, 0.5}, 0.0, 0.5);
  EXPECT_EQ(span.lower, -none);
  EXPECT_DOUBLE_EQ(span.upper, 5.0);
}

}  // namespace leadthrough::rate_box_tests
