#pragma once

// How much of their limits the differences of a sampled motion use.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "time/time_law.hpp"

namespace leadthrough {

// By order 1 to 3: the largest ratio, and the ratio of each difference, which reaches from sample
// k - order to sample k.
struct DifferenceRatios {
  std::array<double, 3> largest{};
  std::array<std::vector<double>, 3> each;
};

// A motion that rests at an end stands still for as long beyond it as differences reach.
struct Rest {
  bool start, end;
};

// lengths: one a sample, `period` apart.
void measure_differences(const PolynomialPath& path, const PathGrid& grid, const RateLimits& limits,
                         const std::vector<double>& lengths, double period, const Rest& rest,
                         DifferenceRatios& ratios);

}  // namespace leadthrough
