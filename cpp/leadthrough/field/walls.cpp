#include "leadthrough/field/walls.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/field/sparse_distance.hpp"

namespace leadthrough {

Walls::Walls(const Blocks& cells, double margin, std::vector<Obstacle> obstacles)
    : cells_(cells), margin_(margin), obstacles_(std::move(obstacles)) {}

std::vector<std::uint8_t> Walls::hold(const std::vector<Index>& cells) const {
  std::vector<std::uint8_t> result(cells.size());
  std::transform(cells.begin(), cells.end(), result.begin(), [this](Index cell) {
    return to_obstacles(cells_.centre(cell), 2.0 * margin_) <= margin_;
  });
  return result;
}

std::vector<double> Walls::distances(const std::vector<Index>& cells, double most) const {
  std::vector<double> result = to_obstacles(cells_, cells, most + margin_);
  const auto is_beside = [&](double away) { return away > margin_ && away < most + margin_; };
  std::vector<Index> beside;
  for (std::size_t n = 0; n < cells.size(); ++n)
    if (is_beside(result[n])) beside.push_back(cells[n]);
  const std::vector<double> found = to_walls(beside, most);
  auto next = found.begin();
  for (double& distance : result) {
    if (is_beside(distance))
      distance = std::min(*next++, most);
    else
      distance = distance <= margin_ ? 0.0 : most;
  }
  return result;
}

std::vector<double> Walls::to_walls(const std::vector<Index>& cells, double most) const {
  if (cells.empty()) return {};
  const CellSet around(cells_.grid, cells_within(cells_.grid, cells, most));
  const std::vector<double> found =
      distance_transform(around, hold(around.cells()).data(), Outside::kUnknown);
  std::vector<double> result(cells.size());
  std::transform(cells.begin(), cells.end(), result.begin(),
                 [&](Index cell) { return found[around.find(cell)]; });
  return result;
}

std::vector<double> Walls::farthest(const Blocks& blocks, const std::vector<Index>& numbers,
                                    double most) const {
  std::vector<double> result = to_obstacles(blocks, numbers, most);
  for (double& distance : result) {
    // The cell that holds an obstacle's nearest point is a wall, its centre a margin away.
    const double bound = distance + blocks.reach;
    distance = bound <= margin_ ? 0.0 : std::min(bound + margin_, most);
  }
  return result;
}

std::vector<double> Walls::nearest(const Blocks& blocks, const std::vector<Index>& numbers,
                                   double most) const {
  std::vector<double> result = to_obstacles(blocks, numbers, most + margin_ + blocks.reach);
  for (double& distance : result) distance = distance - margin_ - blocks.reach;
  return result;
}

std::vector<double> Walls::to_obstacles(const Blocks& blocks, const std::vector<Index>& numbers,
                                        double most) const {
  std::vector<double> result(numbers.size());
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    check_interrupt(n);
    result[n] = to_obstacles(blocks.centre(numbers[n]), most);
  }
  return result;
}

// Signed, and at most `most`.
double Walls::to_obstacles(const Point& point, double most) const {
  double least = most;
  for (const Obstacle& obstacle : obstacles_) {
    const auto may_be_near = [&](std::size_t axis) {
      return std::abs(point[axis] - obstacle.middle[axis]) - obstacle.half[axis] < least;
    };
    if (may_be_near(0) && may_be_near(1) && may_be_near(2))
      least = std::min(least, obstacle.distance(point));
  }
  return least;
}

}  // namespace leadthrough
