#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <random>
#include <utility>
#include <vector>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/field/eikonal.hpp"

namespace leadthrough::eikonal_tests {

namespace {

// The smallest T with sum ((T - value) / spacing)^2 = slowness^2 over the axes where T > value, by
// bisection: slow, but with none of the solver's algebra.
double solve_upwind(const std::array<double, 3>& values, const std::array<double, 3>& spacing,
                    double slowness) {
  double low = kInfinity, widest = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    low = std::min(low, values[axis]);
    widest = std::max(widest, spacing[axis]);
  }
  const double least = low;
  double below = 0.0, above = slowness * widest * (1 + 1e-12);
  for (int n = 0; n < 200; ++n) {
    const double middle = 0.5 * (below + above);
    double sum = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double part = (middle - (values[axis] - least)) / spacing[axis];
      if (part > 0.0) sum += part * part;
    }
    (sum < slowness * slowness ? below : above) = middle;
  }
  return least + 0.5 * (below + above);
}

// Textbook fast marching on a binary heap.
std::vector<double> heap_march(const Grid& grid, const std::vector<double>& speed,
                               const std::vector<Source>& sources) {
  std::vector<double> time(speed.size(), kInfinity);
  std::vector<bool> final(speed.size(), false);
  using Entry = std::pair<double, Index>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> heap;
  for (const Source& source : sources) {
    time[source.cell] = std::min(time[source.cell], source.time);
    heap.push({source.time, source.cell});
  }
  const auto strides = grid.strides();
  const auto neighbour = [&](Index cell, int axis, Index side) {
    const Index at = cell / strides[axis] % grid.shape[axis] + side;
    return at < 0 || at >= grid.shape[axis] ? Index{-1} : cell + side * strides[axis];
  };
  while (!heap.empty()) {
    const Index cell = heap.top().second;
    heap.pop();
    if (final[cell]) continue;
    final[cell] = true;
    for (int axis = 0; axis < 3; ++axis) {
      for (const Index side : {-1, 1}) {
        const Index next = neighbour(cell, axis, side);
        if (next < 0 || final[next] || speed[next] == 0.0) continue;
        std::array<double, 3> values{kInfinity, kInfinity, kInfinity};
        for (int other = 0; other < 3; ++other)
          for (const Index way : {-1, 1})
            if (const Index from = neighbour(next, other, way); from >= 0 && final[from])
              values[other] = std::min(values[other], time[from]);
        const double reached = solve_upwind(values, grid.spacing, 1.0 / speed[next]);
        if (reached >= time[next]) continue;
        time[next] = reached;
        heap.push({reached, next});
      }
    }
  }
  return time;
}

struct Case {
  Grid grid;
  std::vector<double> speed;
  std::vector<Source> sources;
};

// Log-uniform speeds down to `slowest`, walls, sources of different times.
Case random_case(unsigned seed, const Grid& grid, double slowest, double walls, int sources,
                 double latest) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Case result{grid, std::vector<double>(grid.size()), {}};
  for (double& speed : result.speed) {
    speed = std::pow(slowest, uniform(generator));
    if (uniform(generator) < walls) speed = 0.0;
  }
  for (int n = 0; n < sources; ++n) {
    const auto cell = static_cast<Index>(uniform(generator) * static_cast<double>(grid.size()));
    result.speed[cell] = 1.0;
    result.sources.push_back({cell, n == 0 ? 0.0 : latest * uniform(generator)});
  }
  return result;
}

void expect_equal_to_heap(const Case& c) {
  const auto expected = heap_march(c.grid, c.speed, c.sources);
  const auto time = march_first_order(c.grid, c.speed.data(), c.sources);
  std::vector<float> speed(c.speed.begin(), c.speed.end());
  const auto single = march_first_order(c.grid, speed.data(), c.sources);
  for (std::size_t n = 0; n < expected.size(); ++n) {
    if (expected[n] == kInfinity) {
      ASSERT_EQ(time[n], kInfinity) << n;
      ASSERT_EQ(single[n], std::numeric_limits<float>::infinity()) << n;
    } else {
      ASSERT_NEAR(time[n], expected[n], 1e-12 * expected[n]) << n;
      ASSERT_NEAR(single[n], expected[n], 1e-3 * expected[n]) << n;
    }
  }
}

const std::vector<Grid> kGrids = {
    {{1, 30, 41}, {1.0, 1.0, 1.0}}, {{1, 33, 20}, {0.4, 0.4, 1.3}}, {{12, 17, 14}, {1.0, 1.0, 1.0}},
    {{15, 9, 13}, {2.0, 0.3, 0.7}}, {{1, 1, 25}, {1.0, 1.0, 1.0}},  {{8, 1, 9}, {1.0, 1.0, 1.0}},
    {{9, 1, 1}, {1.0, 1.0, 1.0}},   {{1, 1, 1}, {1.0, 1.0, 1.0}},
};

}  // namespace

TEST(Eikonal, FirstOrderEqualsTheHeapAtConstantSpeed) {
  for (const Grid& grid : kGrids) expect_equal_to_heap(random_case(1, grid, 1.0, 0.0, 1, 0.0));
}

TEST(Eikonal, FirstOrderEqualsTheHeapAtRandomSpeedsWithWalls) {
  for (const Grid& grid : kGrids)
    for (unsigned seed = 0; seed < 4; ++seed)
      expect_equal_to_heap(random_case(seed, grid, 0.2, 0.25, 2, 3.0));
}

TEST(Eikonal, FirstOrderEqualsTheHeapAtHugeSpeedRatios) {
  for (const Grid& grid : kGrids) {
    expect_equal_to_heap(random_case(5, grid, 1e-6, 0.1, 2, 1e3));
    expect_equal_to_heap(random_case(6, grid, 1e-12, 0.0, 3, 1e9));
  }
}

TEST(Eikonal, FirstOrderEqualsTheHeapWithSourcesFarApartInTime) {
  for (const Grid& grid : kGrids) expect_equal_to_heap(random_case(7, grid, 0.9, 0.0, 5, 1e7));
}

TEST(Eikonal, AFastRegionInASlowOneIsMarchedCorrectly) {
  Case c = random_case(8, {{1, 40, 40}, {1.0, 1.0, 1.0}}, 1.0, 0.0, 1, 0.0);
  for (Index n = 0; n < c.grid.size(); ++n)
    c.speed[n] = n % 40 > 10 && n % 40 < 30 && n / 40 > 10 && n / 40 < 30 ? 1.0 : 1e-6;
  c.speed[c.sources[0].cell] = 1.0;
  expect_equal_to_heap(c);
}

TEST(Eikonal, TimesOfAnyUnitScaleExactly) {
  Case c = random_case(9, {{10, 11, 12}, {1.0, 1.0, 1.0}}, 0.1, 0.2, 1, 0.0);
  const auto time = march_first_order(c.grid, c.speed.data(), c.sources);
  for (double& speed : c.speed) speed *= 0x1p-900;
  const auto scaled = march_first_order(c.grid, c.speed.data(), c.sources);
  for (std::size_t n = 0; n < time.size(); ++n) EXPECT_EQ(scaled[n], time[n] * 0x1p900);
}

TEST(Eikonal, StoppingKeepsWhatIsNotLaterAndNothingElse) {
  const Case c = random_case(10, {{14, 15, 16}, {1.0, 1.0, 1.0}}, 0.1, 0.1, 1, 0.0);
  for (const auto& march : {march_first_order<double>, march_second_order<double>}) {
    const auto whole = march(c.grid, c.speed.data(), c.sources, kNoStop);
    for (const Index stop : {Index{0}, Index{1234}, c.grid.size() - 1}) {
      if (whole[stop] == kInfinity) continue;
      const auto part = march(c.grid, c.speed.data(), c.sources, stop);
      for (std::size_t n = 0; n < whole.size(); ++n)
        ASSERT_EQ(part[n], whole[n] <= whole[stop] ? whole[n] : kInfinity);
    }
  }
}

TEST(Eikonal, SecondOrderIsCloserToTheDistanceThanFirst) {
  const Grid grid{{31, 31, 31}, {1.0, 1.0, 1.0}};
  const std::vector<double> speed(grid.size(), 1.0);
  const std::vector<Source> sources{{grid.size() / 2, 0.0}};
  const auto first = march_first_order(grid, speed.data(), sources);
  const auto second = march_second_order(grid, speed.data(), sources);
  double first_error = 0.0, second_error = 0.0;
  Index cell = 0;
  for (int x = -15; x <= 15; ++x) {
    for (int y = -15; y <= 15; ++y) {
      for (int z = -15; z <= 15; ++z, ++cell) {
        const double distance = std::sqrt(x * x + y * y + z * z);
        first_error = std::max(first_error, std::abs(first[cell] - distance));
        second_error = std::max(second_error, std::abs(second[cell] - distance));
      }
    }
  }
  EXPECT_LT(first_error, 1.7);
  EXPECT_LT(second_error, 0.65);
}

// Behind slow cells, whose times rise steeply, the second differences of two axes have no common
// solution in a fast one: there the step of first order from 10 and 10 takes its place.
TEST(Eikonal, SecondOrderTakesTheFirstWhereItsDifferencesContradict) {
  const Grid grid{{1, 2, 3}, {1.0, 1.0, 1.0}};
  const std::vector<double> speed{0.0, 0.0, 1.0,  //
                                  1.0, 0.1, 10.0};
  const auto time = march_second_order(grid, speed.data(), {{3, 0.0}, {2, 10.0}});
  ASSERT_NEAR(time[4], 10.0, 1e-12);
  EXPECT_NEAR(time[5], 10.0 + 0.1 * std::sqrt(0.5), 1e-12);
}

TEST(Eikonal, AGridOfTooManyCellsIsRefused) {
  const Grid grid{{1700, 1700, 1700}};
  EXPECT_THROW(march_first_order<float>(grid, nullptr, {{0, 0.0}}), std::length_error);
}

TEST(Eikonal, ABallOfTooManyCellsIsRefused) {
  const Grid grid{{1, 1, 2}};
  const double speed[] = {1.0, 1.0};
  EXPECT_EQ(with_balls(grid, speed, {{0, 0.0}}, kMaxSourceRadius).size(), 2U);
  for (const double radius : {1e30, -1.0, std::nan("")})
    EXPECT_THROW(with_balls(grid, speed, {{0, 0.0}}, radius), std::invalid_argument);
}

TEST(Eikonal, ABallMakesTimesExactUpToTheFirstOtherSpeed) {
  const Grid grid{{1, 21, 31}, {1.0, 1.0, 1.0}};
  std::vector<double> speed(grid.size(), 2.0);
  const Index source = 10 * 31 + 10;
  speed[10 * 31 + 15] = 0.0;  // 5 cells away
  const auto ball = with_balls(grid, speed.data(), {{source, 1.0}}, 9.0);
  double farthest = 0.0;
  for (const Source& cell : ball) {
    const double distance = std::hypot(static_cast<double>(cell.cell / 31 - 10),
                                       static_cast<double>(cell.cell % 31 - 10));
    EXPECT_DOUBLE_EQ(cell.time, 1.0 + distance / 2.0);
    farthest = std::max(farthest, distance);
  }
  EXPECT_DOUBLE_EQ(farthest, std::sqrt(20.0));
}

TEST(Eikonal, SecondOrderFromABallStaysBelowAQuarterOfItsError) {
  const Grid grid{{61, 61, 61}, {1.0, 1.0, 1.0}};
  const std::vector<float> speed(grid.size(), 1.0f);
  const std::vector<Source> source{{grid.size() / 2}};
  const auto error = [&](double radius) {
    const auto time = march(grid, MarchProblem<float>{speed.data(), source}, {2, radius});
    double worst = 0.0;
    Index cell = 0;
    for (int x = -30; x <= 30; ++x)
      for (int y = -30; y <= 30; ++y)
        for (int z = -30; z <= 30; ++z, ++cell)
          worst = std::max(worst, std::abs(time[cell] - std::sqrt(double(x * x + y * y + z * z))));
    return worst;
  };
  EXPECT_LT(error(8.0), 0.25 * error(0.0));
}

}  // namespace leadthrough::eikonal_tests
