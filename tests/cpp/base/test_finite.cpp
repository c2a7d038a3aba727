#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "leadthrough/base/finite.hpp"

namespace leadthrough::finite_tests {

using Limits = std::numeric_limits<double>;

TEST(Finite, LargestSmallestAndZeroAre) {
  const std::vector<double> values = {0.0,
                                      -0.0,
                                      Limits::max(),
                                      Limits::lowest(),
                                      Limits::min(),
                                      Limits::epsilon(),
                                      Limits::denorm_min()};
  EXPECT_TRUE(all_finite(values.data(), values.size()));
  EXPECT_TRUE(all_finite(values.data(), 0));
}

TEST(Finite, OneThatIsNotIsFoundAnywhere) {
  for (const double wrong : {Limits::infinity(), -Limits::infinity(), Limits::quiet_NaN(),
                             -Limits::quiet_NaN(), Limits::signaling_NaN()})
    for (std::size_t count = 1; count < 20; ++count)
      for (std::size_t at = 0; at < count; ++at) {
        std::vector<double> values(count, 1.0);
        values[at] = wrong;
        EXPECT_FALSE(all_finite(values.data(), count)) << at << " of " << count;
      }
}

}  // namespace leadthrough::finite_tests
