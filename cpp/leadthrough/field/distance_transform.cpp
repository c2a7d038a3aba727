#include "leadthrough/field/distance_transform.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/field/lower_envelope.hpp"

namespace leadthrough {

namespace {

// Columns transformed together: neighbours in memory share cache lines.
constexpr Index kTile = 16;

// Squared distances along one row of the mask.
void transform_row(const std::uint8_t* mask, Index size, double spacing, double* squared) {
  double cells = kInfinity;  // since the last cell of the mask
  for (Index n = 0; n < size; ++n) {
    cells = mask[n] ? 0.0 : cells + 1.0;
    squared[n] = cells;
  }
  cells = kInfinity;
  for (Index n = size - 1; n >= 0; --n) {
    cells = mask[n] ? 0.0 : cells + 1.0;
    const double distance = spacing * std::min(cells, squared[n]);
    squared[n] = distance * distance;
  }
}

// Transforms the `size` cells of every column along one axis; columns of one line are neighbours.
void transform_columns(double* squared, Index columns, Index stride, LowerEnvelope& envelope,
                       Index size, std::vector<double>& tile) {
  for (Index first = 0; first < columns; first += kTile) {
    check_interrupt();
    const Index width = std::min(kTile, columns - first);
    for (Index q = 0; q < size; ++q)
      for (Index n = 0; n < width; ++n) tile[n * size + q] = squared[q * stride + first + n];
    for (Index n = 0; n < width; ++n) envelope.transform(tile.data() + n * size, size);
    for (Index q = 0; q < size; ++q)
      for (Index n = 0; n < width; ++n) squared[q * stride + first + n] = tile[n * size + q];
  }
}

}  // namespace

std::vector<double> distance_transform(const Grid& grid, const std::uint8_t* mask) {
  const auto [planes, rows, cells] = grid.shape;
  std::vector<double> squared(static_cast<std::size_t>(grid.size()));
  for (Index row = 0; row < planes * rows; ++row)
    transform_row(mask + row * cells, cells, grid.spacing[2], squared.data() + row * cells);

  std::vector<double> tile(static_cast<std::size_t>(kTile * std::max(planes, rows)));
  if (rows > 1) {
    LowerEnvelope envelope(rows, grid.spacing[1]);
    for (Index plane = 0; plane < planes; ++plane)
      transform_columns(squared.data() + plane * rows * cells, cells, cells, envelope, rows, tile);
  }
  if (planes > 1) {
    LowerEnvelope envelope(planes, grid.spacing[0]);
    transform_columns(squared.data(), rows * cells, rows * cells, envelope, planes, tile);
  }
  for (double& value : squared) value = std::sqrt(value);
  return squared;
}

}  // namespace leadthrough
