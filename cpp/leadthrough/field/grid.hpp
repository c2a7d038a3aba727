#pragma once

#include <array>
#include <cstdint>

namespace leadthrough {

using Index = std::int64_t;

// A regular grid of cells in C order: the last axis is the fastest.
// A 2D grid has a first axis of one cell, whose spacing repeats another axis's.
struct Grid {
  std::array<Index, 3> shape{1, 1, 1};
  std::array<double, 3> spacing{1.0, 1.0, 1.0};  // > 0, between the centres of neighbours

  Index size() const { return shape[0] * shape[1] * shape[2]; }
  std::array<Index, 3> strides() const { return {shape[1] * shape[2], shape[2], 1}; }
};

}  // namespace leadthrough
