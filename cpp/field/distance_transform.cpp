#include "field/distance_transform.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"

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

// The lower envelope of the parabolas values[p] + (spacing (q - p))^2, evaluated at every cell q.
class Envelope {
 public:
  Envelope(Index size, double spacing)
      : scale_(spacing * spacing),
        vertex_(size),
        height_(size),
        from_(size + 1),
        half_inverse_(size) {
    for (Index n = 1; n < size; ++n) half_inverse_[n] = 0.5 / static_cast<double>(n);
  }

  void transform(double* values) {
    if (build(values)) evaluate(values);
  }

 private:
  // All in units of the spacing. Returns whether there is any parabola at all.
  bool build(const double* values) {
    const double per_scale = 1.0 / scale_;
    count_ = 0;
    for (Index q = 0; q < size(); ++q) {
      if (values[q] == kInfinity) continue;
      const double height = values[q] * per_scale + static_cast<double>(q * q);
      double crossing = -kInfinity;
      while (count_ > 0) {
        const Index last = count_ - 1;
        crossing = (height - height_[last]) * half_inverse_[q - vertex_[last]];
        if (crossing > from_[last]) break;
        --count_;
      }
      vertex_[count_] = q;
      height_[count_] = height;
      from_[count_] = count_ == 0 ? -kInfinity : crossing;
      ++count_;
    }
    from_[count_] = kInfinity;
    return count_ > 0;
  }

  void evaluate(double* values) {
    Index n = 0;
    const Index last = count_ - 1;
    base_.assign(values, values + size());
    for (Index q = 0; q < size(); ++q) {
      while (n < last && from_[n + 1] < static_cast<double>(q)) ++n;
      const double cells = static_cast<double>(q - vertex_[n]);
      values[q] = base_[vertex_[n]] + scale_ * cells * cells;
    }
  }

  Index size() const { return static_cast<Index>(vertex_.size()); }

  double scale_;
  Index count_ = 0;
  std::vector<Index> vertex_;   // each parabola's lowest cell
  std::vector<double> height_;  // its value at cell 0
  std::vector<double> from_;    // where it begins to be the lowest
  std::vector<double> half_inverse_;
  std::vector<double> base_;
};

// Transforms the `size` cells of every column along one axis; columns of one line are neighbours.
void transform_columns(double* squared, Index columns, Index stride, Envelope& envelope, Index size,
                       std::vector<double>& tile) {
  for (Index first = 0; first < columns; first += kTile) {
    const Index width = std::min(kTile, columns - first);
    for (Index q = 0; q < size; ++q)
      for (Index n = 0; n < width; ++n) tile[n * size + q] = squared[q * stride + first + n];
    for (Index n = 0; n < width; ++n) envelope.transform(tile.data() + n * size);
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
    Envelope envelope(rows, grid.spacing[1]);
    for (Index plane = 0; plane < planes; ++plane)
      transform_columns(squared.data() + plane * rows * cells, cells, cells, envelope, rows, tile);
  }
  if (planes > 1) {
    Envelope envelope(planes, grid.spacing[0]);
    transform_columns(squared.data(), rows * cells, rows * cells, envelope, planes, tile);
  }
  for (double& value : squared) value = std::sqrt(value);
  return squared;
}

}  // namespace leadthrough
