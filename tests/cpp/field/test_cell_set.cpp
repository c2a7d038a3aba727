#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/field/cell_set.hpp"
#include "leadthrough/field/descent.hpp"
#include "leadthrough/field/distance_transform.hpp"
#include "leadthrough/field/path_distance.hpp"
#include "leadthrough/field/sparse_distance.hpp"
#include "leadthrough/field/sparse_march.hpp"

namespace leadthrough::cell_set_tests {

namespace {

const Grid kFlat{{1, 23, 31}, {1.0, 1.0, 1.5}};
const Grid kSpace{{9, 12, 11}, {1.0, 0.8, 1.3}};

std::vector<Index> some_cells(const Grid& grid, double fraction, std::mt19937& generator) {
  std::bernoulli_distribution chosen(fraction);
  std::vector<Index> cells;
  for (Index cell = 0; cell < grid.size(); ++cell)
    if (chosen(generator)) cells.push_back(cell);
  return cells;
}

std::vector<Index> all_cells(const Grid& grid) {
  std::vector<Index> cells(static_cast<std::size_t>(grid.size()));
  std::iota(cells.begin(), cells.end(), Index(0));
  return cells;
}

std::vector<std::uint8_t> mask_of(const Grid& grid, const std::vector<Index>& cells) {
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(grid.size()), 0);
  for (const Index cell : cells) mask[cell] = 1;
  return mask;
}

}  // namespace

TEST(CellSet, FindsItsCellsAndTheirNeighboursAndNoOthers) {
  std::mt19937 generator(1);
  for (const Grid& grid : {kFlat, kSpace}) {
    const CellSet set(grid, some_cells(grid, 0.3, generator));
    const std::vector<std::uint8_t> held = mask_of(grid, set.cells());
    for (Index cell = 0; cell < grid.size(); ++cell) {
      const CellSet::Place place = set.find(cell);
      ASSERT_EQ(place != set.missing(), held[cell] != 0);
      if (place == set.missing()) continue;
      ASSERT_EQ(set.cells()[place], cell);
      for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {-1, 1}) {
          const Index at = cell / grid.strides()[axis] % grid.shape[axis] + side;
          const bool inside = at >= 0 && at < grid.shape[axis];
          const Index neighbour = cell + side * grid.strides()[axis];
          ASSERT_EQ(set.has_room(place, axis, side), inside);
          ASSERT_EQ(set.next(place, axis, side), inside ? set.find(neighbour) : set.missing());
        }
      }
    }
    EXPECT_EQ(set.find(-1), set.missing());
    EXPECT_EQ(set.find(grid.size()), set.missing());
    EXPECT_EQ(set.next(set.missing(), 1, 1), set.missing());
  }
}

TEST(CellSet, OfNoCellsFindsNone) {
  const CellSet set(kSpace, {});
  EXPECT_EQ(set.find(5), set.missing());
}

TEST(CellSet, CellsWithinARadiusAreThoseOfTheDistanceTransform) {
  std::mt19937 generator(2);
  for (const Grid& grid : {kFlat, kSpace}) {
    const std::vector<Index> cells = some_cells(grid, 0.02, generator);
    const auto distance = distance_transform(grid, mask_of(grid, cells).data());
    for (const double radius : {0.0, 1.4, 3.1}) {
      std::vector<Index> expected;
      for (Index cell = 0; cell < grid.size(); ++cell)
        if (distance[cell] <= radius) expected.push_back(cell);
      EXPECT_EQ(cells_within(grid, cells, radius), expected);
    }
  }
}

TEST(CellSet, FinerCellsAreThoseWhoseHalfIndicesAreGiven) {
  std::mt19937 generator(3);
  for (const Grid& fine : {kFlat, kSpace}) {
    Grid coarse = fine;
    for (Index& count : coarse.shape) count = (count + 1) / 2;
    const std::vector<Index> given = some_cells(coarse, 0.2, generator);
    const std::vector<std::uint8_t> held = mask_of(coarse, given);
    std::vector<Index> expected;
    for (Index cell = 0; cell < fine.size(); ++cell) {
      Index parent = 0;
      for (int axis = 0; axis < 3; ++axis)
        parent += cell / fine.strides()[axis] % fine.shape[axis] / 2 * coarse.strides()[axis];
      if (held[parent]) expected.push_back(cell);
    }
    EXPECT_EQ(finer_cells(coarse, fine, given), expected);
  }
}

TEST(CellSet, DistancesOnAllCellsAreThoseOfTheGrid) {
  std::mt19937 generator(4);
  for (const Grid& grid : {kFlat, kSpace}) {
    const CellSet all(grid, all_cells(grid));
    const auto mask = mask_of(grid, some_cells(grid, 0.03, generator));
    const auto found = distance_transform(all, mask.data(), Outside::kUnknown);
    const auto expected = distance_transform(grid, mask.data());
    for (std::size_t n = 0; n < all.size(); ++n) EXPECT_DOUBLE_EQ(found[n], expected[n]);
  }
}

TEST(CellSet, DepthsAreTheDistancesToTheCellsOutside) {
  std::mt19937 generator(5);
  for (const Grid& grid : {kFlat, kSpace}) {
    const CellSet set(grid, cells_within(grid, some_cells(grid, 0.02, generator), 2.0));
    std::vector<std::uint8_t> outside = mask_of(grid, set.cells());
    for (std::uint8_t& each : outside) each = each ? 0 : 1;
    const auto expected = distance_transform(grid, outside.data());
    const std::vector<std::uint8_t> none(set.size(), 0);
    const auto depth = distance_transform(set, none.data(), Outside::kTarget);
    for (std::size_t n = 0; n < set.size(); ++n)
      EXPECT_DOUBLE_EQ(depth[n], expected[set.cells()[n]]);
  }
}

TEST(CellSet, IsOpenWhereTheWaveMeetsCellsThatItDoesNotHold) {
  const CellSet set(kFlat, cells_within(kFlat, {40}, 4.0));
  std::vector<double> times(set.size(), kInfinity);
  EXPECT_FALSE(set.is_open(times.data()));
  times[set.find(40)] = 0.0;
  EXPECT_FALSE(set.is_open(times.data()));
  times.assign(set.size(), 1.0);
  EXPECT_TRUE(set.is_open(times.data()));
  const CellSet all(kFlat, all_cells(kFlat));
  times.assign(all.size(), 1.0);
  EXPECT_FALSE(all.is_open(times.data()));
}

TEST(CellSet, MarchAndDescentOnAllCellsAreThoseOfTheGrid) {
  std::mt19937 generator(6);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (const Grid& grid : {kFlat, kSpace}) {
    std::vector<double> speed(static_cast<std::size_t>(grid.size()));
    for (double& value : speed) value = uniform(generator) < 0.2 ? 0.0 : 0.1 + uniform(generator);
    const Coordinates start{0.0, 1.2, 1.4};
    const Coordinates goal{static_cast<double>(grid.shape[0] - 1), 8.0, 7.0};
    const Index source = (grid.shape[0] - 1) * grid.strides()[0] + 8 * grid.strides()[1] + 7;
    const Index stop = grid.strides()[1] + 1;
    speed[source] = speed[stop] = 1.0;
    const CellSet all(grid, all_cells(grid));
    const auto times = march_second_order(grid, speed.data(), {{source}}, stop);
    EXPECT_EQ(march_second_order(all, speed.data(), {{source}}, stop), times);
    const auto path = descend(all, times.data(), start, goal, 0.5);
    const auto expected = descend(grid, times.data(), start, goal, 0.5);
    EXPECT_EQ(path.status, expected.status);
    EXPECT_EQ(path.path, expected.path);
  }
}

TEST(CellSet, MarchTakesMissingCellsForWalls) {
  std::mt19937 generator(7);
  const std::vector<Index> held = some_cells(kFlat, 0.75, generator);
  const CellSet set(kFlat, held);
  std::vector<double> walled(static_cast<std::size_t>(kFlat.size()), 0.0);
  for (const Index cell : held) walled[cell] = 1.0 + static_cast<double>(cell % 3);
  std::vector<double> speed;
  for (const Index cell : held) speed.push_back(walled[cell]);
  const auto expected = march_second_order(kFlat, walled.data(), {{held[50]}});
  const auto times = march_second_order(set, speed.data(), {{held[50]}});
  for (std::size_t n = 0; n < held.size(); ++n) EXPECT_EQ(times[n], expected[held[n]]);
}

TEST(CellSet, BallOnAllCellsIsThatOfTheGrid) {
  std::vector<double> speed(static_cast<std::size_t>(kSpace.size()), 2.0);
  speed[7] = 1.0;
  const CellSet all(kSpace, all_cells(kSpace));
  const Source source{400};
  const auto ball = with_ball(all, speed.data(), source, 3.0);
  const auto expected = with_balls(kSpace, speed.data(), {source}, 3.0);
  ASSERT_EQ(ball.size(), expected.size());
  EXPECT_GT(ball.size(), 20U);
  for (std::size_t n = 0; n < ball.size(); ++n) {
    EXPECT_EQ(ball[n].cell, expected[n].cell);
    EXPECT_EQ(ball[n].time, expected[n].time);
  }
}

TEST(PathDistance, IsThatToTheNearestPointOfThePath) {
  std::mt19937 generator(8);
  std::normal_distribution<double> normal;
  for (const std::size_t count : {1, 15, 16, 17, 300}) {
    std::vector<Point> path(count), points(500);
    Point at{};
    for (Point& p : path) {
      for (double& each : at) each += 0.1 * normal(generator);
      p = at;
    }
    for (Point& p : points)
      for (double& each : p) each = 2.0 * normal(generator);
    const auto found = path_distances(points, path, 1.5);
    for (std::size_t n = 0; n < points.size(); ++n) {
      double least = 1.5;
      for (const Point& p : path) {
        const double x = points[n][0] - p[0], y = points[n][1] - p[1], z = points[n][2] - p[2];
        least = std::min(least, std::sqrt(x * x + y * y + z * z));
      }
      EXPECT_NEAR(found[n], least, 1e-15);
    }
  }
}

TEST(CellSet, CentresFollowTheCellsInCOrder) {
  Index cell = 0;
  for (Index x = 0; x < 9; ++x)
    for (Index y = 0; y < 12; ++y)
      for (Index z = 0; z < 11; ++z) {
        const Point centre = centre_of(kSpace, {5.0, 6.0, 7.0}, cell++);
        EXPECT_DOUBLE_EQ(centre[0], 5.0 + static_cast<double>(x));
        EXPECT_DOUBLE_EQ(centre[1], 6.0 + 0.8 * static_cast<double>(y));
        EXPECT_DOUBLE_EQ(centre[2], 7.0 + 1.3 * static_cast<double>(z));
      }
}

}  // namespace leadthrough::cell_set_tests
