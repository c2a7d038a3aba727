#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "leadthrough/field/descent.hpp"
#include "leadthrough/field/eikonal.hpp"

namespace leadthrough::descent_tests {

namespace {

Index cell_of(const Grid& grid, const Coordinates& p) {
  const auto strides = grid.strides();
  Index cell = 0;
  for (int axis = 0; axis < 3; ++axis)
    cell += static_cast<Index>(std::floor(p[axis] + 0.5)) * strides[axis];
  return cell;
}

}  // namespace

TEST(Descent, EndsOnTheGoalOutsideTheWallsOfRandomMazes) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  int found = 0;
  for (int repeat = 0; repeat < 200; ++repeat) {
    const Grid grid = repeat % 2 ? Grid{{1, 20, 25}, {1.0, 1.0, 1.5}} : Grid{{9, 8, 10}};
    std::vector<double> speed(grid.size());
    for (double& value : speed) value = uniform(generator) < 0.35 ? 0.0 : 0.1 + uniform(generator);
    Coordinates start{}, goal{};
    for (int axis = 0; axis < 3; ++axis) {
      if (grid.shape[axis] == 1) continue;
      start[axis] = uniform(generator) * static_cast<double>(grid.shape[axis]) - 0.5;
      goal[axis] = uniform(generator) * static_cast<double>(grid.shape[axis]) - 0.5;
    }
    speed[cell_of(grid, goal)] = 1.0;
    const auto time = march_first_order(grid, speed.data(), {{cell_of(grid, goal), 0.0}});
    const auto descent = descend(grid, time.data(), start, goal, 0.5);
    if (std::isinf(time[cell_of(grid, start)])) {
      EXPECT_EQ(descent.status, DescentStatus::kStartUnreached);
      continue;
    }
    ++found;
    ASSERT_EQ(descent.status, DescentStatus::kOk);
    EXPECT_EQ(descent.path.front(), start);
    EXPECT_EQ(descent.path.back(), goal);
    for (std::size_t n = 1; n < descent.path.size(); ++n) {
      for (int part = 0; part <= 40; ++part) {
        Coordinates p{};
        for (int axis = 0; axis < 3; ++axis)
          p[axis] = descent.path[n - 1][axis] +
                    part / 40.0 * (descent.path[n][axis] - descent.path[n - 1][axis]);
        ASSERT_FALSE(std::isinf(time[cell_of(grid, p)]));
      }
    }
  }
  EXPECT_GT(found, 50);
}

TEST(Descent, EndsAtTheOtherSourceWithAnError) {
  const Grid grid{{1, 9, 9}};
  const std::vector<double> speed(81, 1.0);
  const auto time = march_first_order(grid, speed.data(), {{0, 0.0}, {80, 0.0}});
  EXPECT_EQ(descend(grid, time.data(), {0, 1, 3}, {0, 8, 8}, 0.5).status,
            DescentStatus::kOtherSource);
}

TEST(Descent, FindsAWayOutOfAFastRegionWhoseTimesAreLostInRounding) {
  const Grid grid{{1, 40, 40}};
  std::vector<float> speed(grid.size());
  for (Index n = 0; n < grid.size(); ++n) speed[n] = n % 40 > 5 && n / 40 > 5 ? 1.0f : 1e-12f;
  for (const auto& march : {march_first_order<float>, march_second_order<float>}) {
    const auto single = march(grid, speed.data(), {{0, 0.0}}, kNoStop);
    const std::vector<double> time(single.begin(), single.end());
    EXPECT_EQ(descend(grid, time.data(), {0, 35, 35}, {0, 0, 0}, 0.5).status, DescentStatus::kOk);
  }
}

TEST(Descent, SaysWhyThereIsNoPath) {
  const Grid grid{{1, 5, 5}};
  std::vector<double> speed(25, 1.0);
  for (int row = 0; row < 5; ++row) speed[row * 5 + 2] = 0.0;
  const auto time = march_first_order(grid, speed.data(), {{0, 0.0}});
  const auto status = [&](const Coordinates& start, const Coordinates& goal) {
    return descend(grid, time.data(), start, goal, 0.5).status;
  };
  EXPECT_EQ(status({0, 4, 1}, {0, 0, 0}), DescentStatus::kOk);
  EXPECT_EQ(status({0, 4.6, 1}, {0, 0, 0}), DescentStatus::kStartOutside);
  EXPECT_EQ(status({0, 4, 2}, {0, 0, 0}), DescentStatus::kStartUnreached);
  EXPECT_EQ(status({0, 4, 4}, {0, 0, 0}), DescentStatus::kStartUnreached);
  EXPECT_EQ(status({0, 2, 0}, {0, 4, 0}), DescentStatus::kGoalNotSource);
  EXPECT_EQ(status({0, 2, 0}, {0, 4, 2}), DescentStatus::kGoalNotSource);
}

TEST(Descent, EndsAtTimesThatAreNoNumbers) {
  const Grid grid{{1, 30, 30}};
  std::vector<double> time(900);
  for (Index x = 0; x < 30; ++x)
    for (Index y = 0; y < 30; ++y) time[30 * x + y] = std::hypot(x, y);
  for (Index y = 0; y < 30; ++y) time[30 * 15 + y] = time[30 * 16 + y] = std::nan("");
  const auto descent = descend(grid, time.data(), {0, 25, 25}, {0, 0, 0}, 0.5);
  EXPECT_EQ(descent.status, DescentStatus::kNotTimes);
}

TEST(Descent, DirectionsLeadDownWithoutTouchingAWall) {
  std::mt19937 generator(2);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int repeat = 0; repeat < 200; ++repeat) {
    const Grid grid = repeat % 2 ? Grid{{1, 12, 15}, {1.0, 1.0, 1.5}} : Grid{{6, 8, 5}};
    std::vector<float> speed(grid.size());
    for (float& value : speed)
      value = uniform(generator) < 0.35 ? 0.0f : static_cast<float>(0.1 + uniform(generator));
    speed[0] = 1.0f;
    const auto time = march_first_order(grid, speed.data(), {{0}});
    Coordinates p{};
    for (int axis = 0; axis < 3; ++axis)
      if (grid.shape[axis] > 1)
        p[axis] = uniform(generator) * static_cast<double>(grid.shape[axis]) - 0.5;
    const auto direction = leadthrough::direction(grid, time.data(), p);
    if (std::isinf(time[cell_of(grid, p)])) {
      EXPECT_EQ(direction.status, DescentStatus::kStartUnreached);
      continue;
    }
    ASSERT_EQ(direction.status, DescentStatus::kOk);
    if (cell_of(grid, p) == 0) continue;
    EXPECT_NEAR(std::hypot(direction.unit[0], direction.unit[1], direction.unit[2]), 1.0, 1e-12);
    for (int part = 0; part <= 40; ++part) {
      Coordinates q = p;
      for (int axis = 0; axis < 3; ++axis)
        q[axis] += 0.5 * part / 40.0 * direction.unit[axis] / grid.spacing[axis];
      ASSERT_FALSE(std::isinf(time[cell_of(grid, q)]));
    }
  }
}

TEST(Descent, TheDirectionAtASourceIsZero) {
  const Grid grid{{1, 5, 5}};
  const std::vector<double> speed(grid.size(), 1.0);
  const auto time = march_first_order(grid, speed.data(), {{12}});
  EXPECT_EQ(direction(grid, time.data(), {0, 2, 2}).unit, (Coordinates{0, 0, 0}));
  EXPECT_EQ(direction(grid, time.data(), {0, 9, 2}).status, DescentStatus::kStartOutside);
}

}  // namespace leadthrough::descent_tests
