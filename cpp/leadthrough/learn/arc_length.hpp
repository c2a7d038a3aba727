#pragma once

// Curves given by points, sampled by arc length.

#include <cstddef>
#include <vector>

namespace leadthrough {

// A line through points, which are rows.
struct Polyline {
  const double* points;
  std::size_t count;      // > 0
  std::size_t dimension;  // > 0

  const double* at(std::size_t n) const { return points + n * dimension; }
};

// Of the polygonal line through the points, from the first one to each, from 0 on.
std::vector<double> arc_lengths(const Polyline& curve);

// `count` points, at least 2, evenly spaced in arc length along the polygonal line, row by row. The
// lengths are its own.
std::vector<double> by_arc_length(const Polyline& curve, const std::vector<double>& lengths,
                                  std::size_t count);

// Root mean squares of the distances of curves' points of the same number, from each curve to each:
// (count, count), row by row. The curves lie in memory one after the other.
std::vector<double> rms_apart(const Polyline& first, std::size_t count);

}  // namespace leadthrough
