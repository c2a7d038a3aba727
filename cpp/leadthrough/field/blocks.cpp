#include "leadthrough/field/blocks.hpp"

#include <algorithm>
#include <cmath>

namespace leadthrough {

std::vector<Point> Blocks::centres(const std::vector<Index>& numbers) const {
  std::vector<Point> result(numbers.size());
  std::transform(numbers.begin(), numbers.end(), result.begin(),
                 [this](Index each) { return centre(each); });
  return result;
}

std::array<Index, 3> Blocks::place(Index number) const {
  const Index row = number / grid.shape[2];
  const Index layer = row / grid.shape[1];
  return {layer, row - layer * grid.shape[1], number - row * grid.shape[2]};
}

Index Blocks::number(const std::array<Index, 3>& place) const {
  return (place[0] * grid.shape[1] + place[1]) * grid.shape[2] + place[2];
}

std::optional<Index> Blocks::find(const Point& point) const {
  std::array<Index, 3> at;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double nearest = std::floor((point[axis] - first[axis]) / grid.spacing[axis] + 0.5);
    if (!(nearest >= 0.0 && nearest < static_cast<double>(grid.shape[axis]))) return std::nullopt;
    at[axis] = static_cast<Index>(nearest);
  }
  return number(at);
}

Blocks blocks_of(const Blocks& cells, int level) {
  Blocks blocks = cells;
  const Index size = Index(1) << level;
  const double beyond = 0.5 * static_cast<double>(size - 1);
  double squared = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double spacing = cells.grid.spacing[axis];
    blocks.grid.shape[axis] = (cells.grid.shape[axis] + size - 1) >> level;
    blocks.grid.spacing[axis] = spacing * static_cast<double>(size);
    if (axis < 3 - static_cast<std::size_t>(cells.dimensions)) continue;
    blocks.first[axis] += beyond * spacing;
    squared += spacing * spacing;
  }
  blocks.level = level;
  blocks.reach = beyond * std::sqrt(squared);
  return blocks;
}

Index block_around(const Blocks& blocks, const Blocks& cells, Index cell) {
  std::array<Index, 3> at = cells.place(cell);
  for (Index& each : at) each >>= blocks.level;
  return blocks.number(at);
}

}  // namespace leadthrough
