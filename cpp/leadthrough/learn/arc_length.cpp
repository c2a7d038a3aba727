#include "leadthrough/learn/arc_length.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

constexpr std::size_t kMostNumbers = std::size_t{1} << 28;

// In eight sums side by side, as far as there are eight numbers: that rounds less.
double squared_distance(const double* a, const double* b, std::size_t dimension) {
  constexpr std::size_t kSums = 8;
  const auto square = [&](std::size_t n) { return (b[n] - a[n]) * (b[n] - a[n]); };
  double total = 0.0;
  std::size_t n = 0;
  if (dimension >= kSums) {
    std::array<double, kSums> sums{};
    for (; n + kSums <= dimension; n += kSums)
      for (std::size_t k = 0; k < kSums; ++k) sums[k] += square(n + k);
    total =
        ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
  }
  for (; n < dimension; ++n) total += square(n);
  return total;
}

}  // namespace

std::vector<double> arc_lengths(const Polyline& curve) {
  std::vector<double> lengths(curve.count, 0.0);
  for (std::size_t n = 1; n < curve.count; ++n)
    lengths[n] =
        lengths[n - 1] + std::sqrt(squared_distance(curve.at(n - 1), curve.at(n), curve.dimension));
  return lengths;
}

std::vector<double> by_arc_length(const Polyline& curve, const std::vector<double>& lengths,
                                  std::size_t count) {
  check_argument(count <= kMostNumbers / std::max<std::size_t>(curve.dimension, 1),
                 "count: expected at most 2^28 numbers in all");
  // A step that adds no length has no inside to interpolate in: its points are passed over.
  std::vector<std::size_t> distinct{0};
  for (std::size_t n = 1; n < curve.count; ++n)
    if (lengths[n] > lengths[n - 1]) distinct.push_back(n);
  const auto intervals = static_cast<double>(count - 1);
  const double length = lengths.back(), step = length / intervals;
  std::vector<double> result(count * curve.dimension);
  double* to = result.data();
  for (std::size_t n = 0, left = 0; n < count; ++n) {
    check_interrupt(n);
    if (distinct.size() == 1) {
      to = std::copy_n(curve.points, curve.dimension, to);
      continue;
    }
    const double wanted = n + 1 == count ? length : static_cast<double>(n) * step;
    while (left + 2 < distinct.size() && lengths[distinct[left + 1]] <= wanted) ++left;
    const std::size_t before = distinct[left], after = distinct[left + 1];
    const double part = (wanted - lengths[before]) / (lengths[after] - lengths[before]);
    for (std::size_t k = 0; k < curve.dimension; ++k)
      *to++ = (1.0 - part) * curve.at(before)[k] + part * curve.at(after)[k];
  }
  return result;
}

std::vector<double> rms_apart(const Polyline& first, std::size_t count) {
  const std::size_t size = first.count * first.dimension;
  std::vector<double> result(count * count, 0.0);
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = a + 1; b < count; ++b) {
      check_interrupt(b);
      const double total = squared_distance(first.points + a * size, first.points + b * size, size);
      const double apart = std::sqrt(total / static_cast<double>(first.count));
      result[a * count + b] = result[b * count + a] = apart;
    }
  }
  return result;
}

}  // namespace leadthrough
