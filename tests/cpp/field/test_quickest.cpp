#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/field/hindered_speeds.hpp"
#include "leadthrough/field/quickest.hpp"

namespace leadthrough::quickest_tests {

namespace {

// A map that counts the cells and blocks that it is asked for.
class Counted : public SpeedMap {
 public:
  explicit Counted(const SpeedMap& map) : SpeedMap(map.cells(), map.outside()), map_(map) {}

  std::vector<double> at(const std::vector<Index>& cells) const override {
    count += cells.size();
    asked.push_back(cells);
    return map_.at(cells);
  }
  std::vector<double> fastest(const Blocks& blocks,
                              const std::vector<Index>& numbers) const override {
    count += numbers.size();
    return map_.fastest(blocks, numbers);
  }

  mutable std::size_t count = 0;
  mutable std::vector<std::vector<Index>> asked;

 private:
  const SpeedMap& map_;
};

std::vector<Point> arc() {
  std::vector<Point> path;
  for (int n = 0; n <= 400; ++n) {
    const double u = n / 400.0;
    path.push_back({0.6 * u, 0.1 * std::sin(kPi * u), 0.1 * u});
  }
  return path;
}

Blocks cells_about_arc(double margin) {
  const double spacing = 0.005;
  const auto count = [&](double length) {
    return static_cast<Index>((length + 2 * margin) / spacing);
  };
  return {{{count(0.6), count(0.1), count(0.1)}, {spacing, spacing, spacing}},
          {-margin, -margin, -margin}};
}

Obstacle ball(const Point& middle, double radius) {
  const auto distance = [=](const Point& p) {
    return std::sqrt(std::pow(p[0] - middle[0], 2) + std::pow(p[1] - middle[1], 2) +
                     std::pow(p[2] - middle[2], 2)) -
           radius;
  };
  return {distance, middle, {radius, radius, radius}};
}

// The speeds in a wide tube about the arc, with a ball half way.
std::shared_ptr<const SpeedMap> tube_past_ball(const Blocks& cells) {
  const auto path = arc();
  const auto free = std::make_shared<TubeSpeeds>(cells, 0.02, std::vector<Tube>{{path, 1.0}}, 0.2);
  return std::make_shared<HinderedSpeeds>(
      free, Walls(cells, 0.0044, {ball(path[path.size() / 2], 0.04)}), 0.012);
}

}  // namespace

TEST(Quickest, CostGrowsWithThePathAndNotWithTheMap) {
  std::vector<std::size_t> counts;
  for (const double margin : {0.15, 0.5}) {
    const auto map = tube_past_ball(cells_about_arc(margin));
    const Counted counted(*map);
    const auto path = arc();
    ASSERT_EQ(quickest_path(counted, path.front(), path.back()).status, QuickestStatus::kFound);
    counts.push_back(counted.count);
    EXPECT_LT(100 * counted.count,
              static_cast<std::size_t>(map->cells().grid.size()) * (margin > 0.3 ? 1 : 20));
  }
  EXPECT_LT(counts[1], 2 * counts[0]);
}

TEST(Quickest, AsksForNoCellTwice) {
  const auto map = tube_past_ball(cells_about_arc(0.15));
  const Counted counted(*map);
  const auto path = arc();
  quickest_path(counted, path.front(), path.back());
  ASSERT_GT(counted.asked.size(), 3u) << "the band never widened";
  std::set<Index> seen;
  for (std::size_t n = 2; n < counted.asked.size(); ++n)  // after start and goal
    for (const Index cell : counted.asked[n]) EXPECT_TRUE(seen.insert(cell).second);
}

TEST(Quickest, SpeedsThatAreNoSpeedsAreRefused) {
  const Blocks cells{{{1, 4, 4}}, {}};
  for (const double wrong : {kInfinity, std::nan(""), -1.0}) {
    std::vector<double> speeds(16, 1.0);
    speeds[5] = wrong;
    EXPECT_THROW(GivenSpeeds(cells, 0.0, speeds), std::invalid_argument);
  }
  EXPECT_THROW(GivenSpeeds(cells, 0.0, {1.0}), std::invalid_argument);
}

TEST(Quickest, EndsWhoseDistanceOverflowsAreRefused) {
  const auto map = tube_past_ball(cells_about_arc(0.15));
  const Point start = arc().front();
  EXPECT_EQ(quickest_path(*map, start, {1e100, 0.0, 0.0}).status, QuickestStatus::kFound);
  for (const double wrong : {1e200, 1e300, kInfinity, std::nan("")})
    EXPECT_THROW(quickest_path(*map, start, {wrong, 0.0, 0.0}), std::invalid_argument);
}

TEST(Blocks, CountFromTheFirstCellAndReachTheirCells) {
  const Blocks cells{{{1, 9, 6}, {0.5, 0.5, 0.25}}, {0.0, 1.0, 2.0}, 2};
  const Blocks blocks = blocks_of(cells, 2);
  EXPECT_EQ(blocks.grid.shape, (std::array<Index, 3>{1, 3, 2}));
  for (Index cell = 0; cell < cells.grid.size(); ++cell) {
    const Point a = cells.centre(cell), b = blocks.centre(block_around(blocks, cells, cell));
    EXPECT_LE(std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]), blocks.reach + 1e-12);
    EXPECT_EQ(cells.find(a), cell);
  }
  EXPECT_FALSE(cells.find({0.0, 0.7, 2.0}).has_value());
}

}  // namespace leadthrough::quickest_tests
