#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "leadthrough/field/distance_transform.hpp"

namespace leadthrough::distance_transform_tests {

namespace {

std::vector<double> brute_force(const Grid& grid, const std::vector<std::uint8_t>& mask) {
  const auto strides = grid.strides();
  std::vector<double> result(mask.size(), std::numeric_limits<double>::infinity());
  for (Index a = 0; a < grid.size(); ++a) {
    for (Index b = 0; b < grid.size(); ++b) {
      if (!mask[b]) continue;
      double squared = 0.0;
      for (int axis = 0; axis < 3; ++axis) {
        const Index difference =
            a / strides[axis] % grid.shape[axis] - b / strides[axis] % grid.shape[axis];
        squared += std::pow(grid.spacing[axis] * static_cast<double>(difference), 2);
      }
      result[a] = std::min(result[a], std::sqrt(squared));
    }
  }
  return result;
}

}  // namespace

TEST(Distance, EqualsTheSearchOverAllPairs) {
  std::mt19937 generator(1);
  for (const Grid& grid : std::vector<Grid>{{{9, 10, 11}, {1.0, 1.0, 1.0}},
                                            {{7, 19, 6}, {0.3, 1.7, 1.1}},
                                            {{1, 20, 33}, {1.0, 1.0, 0.2}},
                                            {{1, 1, 12}, {1.0, 1.0, 2.0}},
                                            {{13, 1, 1}, {0.5, 1.0, 1.0}},
                                            {{1, 1, 1}, {1.0, 1.0, 1.0}}}) {
    for (const unsigned one_in : {2u, 50u, 100000u}) {
      std::vector<std::uint8_t> mask(grid.size());
      for (auto& cell : mask) cell = generator() % one_in == 0;
      const auto expected = brute_force(grid, mask);
      const auto distance = distance_transform(grid, mask.data());
      for (std::size_t n = 0; n < expected.size(); ++n) {
        if (std::isinf(expected[n])) {
          ASSERT_EQ(distance[n], expected[n]);
        } else {
          ASSERT_NEAR(distance[n], expected[n], 1e-13 * (1.0 + expected[n]));
        }
      }
    }
  }
}

}  // namespace leadthrough::distance_transform_tests
