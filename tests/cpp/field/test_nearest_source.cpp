#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "leadthrough/field/eikonal.hpp"
#include "leadthrough/field/nearest_source.hpp"

namespace leadthrough::nearest_source_tests {

TEST(NearestSource, IsTheNearerOneAtConstantSpeed) {
  const Grid grid{{1, 80, 90}, {1.0, 1.0, 0.5}};
  const std::vector<double> speed(grid.size(), 1.0);
  const std::vector<Index> sources{10 * 90 + 20, 40 * 90 + 70, 70 * 90 + 5};
  const auto times =
      march_second_order(grid, speed.data(), {{sources[0]}, {sources[1]}, {sources[2]}});
  const auto labels = nearest_sources(grid, times.data(), sources);
  for (Index cell = 0; cell < grid.size(); ++cell) {
    std::vector<double> distances;
    for (const Index source : sources)
      distances.push_back(std::hypot(static_cast<double>(cell / 90 - source / 90),
                                     0.5 * static_cast<double>(cell % 90 - source % 90)));
    const double nearest = *std::min_element(distances.begin(), distances.end());
    ASSERT_LT(distances[labels[cell]] - nearest, 2.0) << cell;
  }
}

TEST(NearestSource, IsNoneWhereTheFrontDoesNotCome) {
  const Grid grid{{1, 1, 4}};
  const std::vector<double> times{0.0, 1.0, std::numeric_limits<double>::infinity(), 5.0};
  EXPECT_EQ(nearest_sources(grid, times.data(), {0}), (std::vector<std::int32_t>{0, 0, -1, -1}));
}

}  // namespace leadthrough::nearest_source_tests
