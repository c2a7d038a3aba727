#include "leadthrough/field/speed_map.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/finite.hpp"
#include "leadthrough/field/sparse_distance.hpp"

namespace leadthrough {

namespace {

// Ascending numbers of the cells that points lie in.
std::vector<Index> crossed_by(const std::vector<std::vector<Point>>& paths, const Blocks& cells) {
  std::vector<Index> crossed;
  for (const auto& path : paths)
    for (const Point& point : path)
      if (const auto cell = cells.find(point)) crossed.push_back(*cell);
  std::sort(crossed.begin(), crossed.end());
  crossed.erase(std::unique(crossed.begin(), crossed.end()), crossed.end());
  return crossed;
}

double diagonal_of(const Blocks& cells) {
  double squared = 0.0;
  for (std::size_t axis = 3 - static_cast<std::size_t>(cells.dimensions); axis < 3; ++axis)
    squared += cells.grid.spacing[axis] * cells.grid.spacing[axis];
  return std::sqrt(squared);
}

}  // namespace

GivenSpeeds::GivenSpeeds(const Blocks& cells, double outside, std::vector<double> speeds)
    : SpeedMap(cells, outside), speeds_(std::move(speeds)) {
  check_argument(static_cast<Index>(speeds_.size()) == cells.grid.size() &&
                     all_finite(speeds_.data(), speeds_.size()) &&
                     std::all_of(speeds_.begin(), speeds_.end(), [](double v) { return v >= 0.0; }),
                 "speeds: expected one finite number >= 0 a cell");
}

std::vector<double> GivenSpeeds::at(const std::vector<Index>& cells) const {
  std::vector<double> result(cells.size());
  std::transform(cells.begin(), cells.end(), result.begin(),
                 [this](Index cell) { return speeds_[static_cast<std::size_t>(cell)]; });
  return result;
}

std::vector<double> GivenSpeeds::fastest(const Blocks& blocks,
                                         const std::vector<Index>& numbers) const {
  std::vector<double> result(numbers.size());
  std::transform(numbers.begin(), numbers.end(), result.begin(),
                 [&](Index number) { return fastest_in(blocks, number); });
  return result;
}

double GivenSpeeds::fastest_in(const Blocks& blocks, Index number) const {
  const auto& shape = cells().grid.shape;
  std::array<Index, 3> begin = blocks.place(number), end;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    begin[axis] <<= blocks.level;
    end[axis] = std::min(begin[axis] + (Index(1) << blocks.level), shape[axis]);
  }
  double fastest = 0.0;
  for (Index x = begin[0]; x < end[0]; ++x) {
    for (Index y = begin[1]; y < end[1]; ++y) {
      const double* row = speeds_.data() + (x * shape[1] + y) * shape[2];
      fastest = std::max(fastest, *std::max_element(row + begin[2], row + end[2]));
    }
  }
  return fastest;
}

ExperienceSpeeds::ExperienceSpeeds(const Blocks& cells, double saturation,
                                   const std::vector<std::vector<Point>>& paths, double radius)
    : FreeSpeeds(cells, saturation) {
  const CellSet tube(cells.grid, cells_within(cells.grid, crossed_by(paths, cells),
                                              radius * (1.0 + kRadiusRounding)));
  const std::vector<std::uint8_t> none(tube.size(), 0);
  std::vector<double> speeds = distance_transform(tube, none.data(), Outside::kTarget);
  const double deepest = speeds.empty() ? 0.0 : *std::max_element(speeds.begin(), speeds.end());
  // Experience everywhere has no border.
  for (double& each : speeds)
    each = saturation + (1.0 - saturation) * (std::isinf(deepest) ? 1.0 : each / deepest);
  levels_.push_back({tube.cells(), std::move(speeds)});
  for (Blocks fine = cells; fine.grid.size() > 1;) {
    const Blocks blocks = blocks_of(cells, fine.level + 1);
    levels_.push_back(coarser(levels_.back(), fine, blocks));
    fine = blocks;
  }
}

ExperienceSpeeds::Level ExperienceSpeeds::coarser(const Level& fine, const Blocks& fine_blocks,
                                                  const Blocks& blocks) const {
  std::vector<std::pair<Index, double>> held(fine.numbers.size());
  for (std::size_t n = 0; n < held.size(); ++n) {
    auto at = fine_blocks.place(fine.numbers[n]);
    for (Index& each : at) each /= 2;
    held[n] = {blocks.number(at), fine.speeds[n]};
  }
  std::sort(held.begin(), held.end());
  Level level;
  for (const auto& [number, speed] : held) {
    if (level.numbers.empty() || level.numbers.back() != number) {
      level.numbers.push_back(number);
      level.speeds.push_back(speed);
    } else {
      level.speeds.back() = speed;  // speeds of one block ascend
    }
  }
  return level;
}

std::vector<double> ExperienceSpeeds::at(const std::vector<Index>& cells) const {
  return looked_up(levels_.front(), cells);
}

std::vector<double> ExperienceSpeeds::fastest(const Blocks& blocks,
                                              const std::vector<Index>& numbers) const {
  return looked_up(levels_[static_cast<std::size_t>(blocks.level)], numbers);
}

std::vector<double> ExperienceSpeeds::looked_up(const Level& level,
                                                const std::vector<Index>& numbers) const {
  std::vector<double> result(numbers.size(), saturation());
  auto next = level.numbers.begin();
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    next = std::lower_bound(next, level.numbers.end(), numbers[n]);
    if (next == level.numbers.end()) break;
    if (*next == numbers[n]) result[n] = level.speeds[next - level.numbers.begin()];
  }
  return result;
}

TubeSpeeds::TubeSpeeds(const Blocks& cells, double saturation, std::vector<Tube> tubes,
                       double radius)
    : FreeSpeeds(cells, saturation), tubes_(std::move(tubes)), radius_(radius) {}

std::vector<double> TubeSpeeds::at(const std::vector<Index>& cells) const {
  return fastest(this->cells(), cells);
}

std::vector<double> TubeSpeeds::fastest(const Blocks& blocks,
                                        const std::vector<Index>& numbers) const {
  const std::vector<Point> points = blocks.centres(numbers);
  std::vector<double> speeds(numbers.size(), 0.0);
  for (const Tube& tube : tubes_) {
    const std::vector<double> away = path_distances(points, tube.path, radius_ + blocks.reach);
    for (std::size_t n = 0; n < speeds.size(); ++n) {
      const double nearest = std::max(away[n] - blocks.reach, 0.0);
      speeds[n] = std::max(speeds[n], tube.weight * std::max(1.0 - nearest / radius_, 0.0));
    }
  }
  for (double& speed : speeds) speed = saturation() + (1.0 - saturation()) * speed;
  return speeds;
}

std::vector<Index> TubeSpeeds::in_tube() const {
  std::vector<std::vector<Point>> paths;
  for (const Tube& tube : tubes_) paths.push_back(tube.path);
  const double reach = radius_ + 0.5 * diagonal_of(cells());
  std::vector<Index> near = cells_within(cells().grid, crossed_by(paths, cells()), reach);
  const std::vector<double> speeds = at(near);
  auto kept = near.begin();
  for (std::size_t n = 0; n < speeds.size(); ++n)
    if (speeds[n] > saturation()) *kept++ = near[n];
  near.erase(kept, near.end());
  return near;
}

}  // namespace leadthrough
