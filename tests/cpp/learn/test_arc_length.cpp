#include <gtest/gtest.h>

#include <array>
#include <stdexcept>
#include <vector>

#include "leadthrough/learn/arc_length.hpp"

namespace leadthrough::arc_length_tests {

TEST(ArcLength, PointsAreEvenlySpacedAlongTheLine) {
  const std::array<double, 6> corner{0.0, 0.0, 3.0, 0.0, 3.0, 1.0};
  const Polyline curve{corner.data(), 3, 2};
  const std::vector<double> expected{0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 3.0, 0.0, 3.0, 1.0};
  EXPECT_EQ(by_arc_length(curve, arc_lengths(curve), 5), expected);
}

TEST(ArcLength, MorePointsThanMemoryIsWorthAreRefused) {
  const std::array<double, 2> line{0.0, 1.0};
  const Polyline curve{line.data(), 2, 1};
  EXPECT_THROW(by_arc_length(curve, arc_lengths(curve), std::size_t{1} << 31),
               std::invalid_argument);
}

}  // namespace leadthrough::arc_length_tests
