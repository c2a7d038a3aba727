#pragma once

// How much of their limits the samples of a law use, and the quintics between them.

#include <array>
#include <vector>

#include "leadthrough/time/path_grid.hpp"
#include "leadthrough/time/rate_limits.hpp"

namespace leadthrough {

// A limit may be exceeded by this part of it, for the rounding of samples at high rates.
constexpr double kAllowedExcess = 5e-7;

// A motion's length along its path, with two derivatives in time, sample by sample.
struct LawSamples {
  std::vector<double> length, speed, push;

  std::size_t size() const { return length.size(); }
  // How many samples from the first on are the same.
  std::size_t same_as(const LawSamples& other) const;
};

// Samples that are judged: every one of `parts`, `period` apart from the next in the law. An end at
// which the motion rests counts as standing still beyond it. Between them are the quintics of
// QuinticStep; where those don't count, the values at the samples do.
struct Judged {
  double period;
  Eigen::Index parts;
  bool between, rests_at_start, rests_at_end;
};

// By order 1 to 3: the largest ratio, and that of the step that ends at each sample; 0 where the
// limit is kept but for what is allowed. The jerk is the difference of the acceleration over a step
// and, between samples, of the positions over three.
struct LimitRatios {
  std::array<double, 3> largest{};
  std::array<std::vector<double>, 3> each;
};

// The first `same` samples of the law are those that `ratios` was measured of.
void measure_use(const PolynomialPath& path, const PathGrid& grid, const RateLimits& limits,
                 const LawSamples& law, const Judged& judged, std::size_t same,
                 LimitRatios& ratios);

}  // namespace leadthrough
