#include "leadthrough/field/hindered_speeds.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace leadthrough {

namespace {

// Cells faster than the saturation by more than this fraction lie in a tube.
constexpr double kInTube = 1e-6;

}  // namespace

HinderedSpeeds::HinderedSpeeds(std::shared_ptr<const SpeedMap> free, Walls walls, double reach)
    : SpeedMap(free->cells(), free->outside()),
      free_(std::move(free)),
      walls_(std::move(walls)),
      reach_(reach) {}

std::vector<double> HinderedSpeeds::at(const std::vector<Index>& cells) const {
  std::vector<double> result = walls_.distances(cells, reach_);
  const std::vector<double> free = free_->at(cells);
  for (std::size_t n = 0; n < result.size(); ++n) result[n] = free[n] * (result[n] / reach_);
  return result;
}

std::vector<double> HinderedSpeeds::fastest(const Blocks& blocks,
                                            const std::vector<Index>& numbers) const {
  std::vector<double> result = walls_.farthest(blocks, numbers, reach_);
  const std::vector<double> free = free_->fastest(blocks, numbers);
  for (std::size_t n = 0; n < result.size(); ++n) result[n] = free[n] * (result[n] / reach_);
  return result;
}

SaturatedSpeeds::SaturatedSpeeds(std::shared_ptr<const SpeedMap> free, Walls walls, double reach,
                                 double saturation)
    : SpeedMap(free->cells(), free->outside()),
      free_(std::move(free)),
      walls_(std::move(walls)),
      reach_(reach),
      saturation_(saturation) {}

std::vector<double> SaturatedSpeeds::at(const std::vector<Index>& cells) const {
  return lowered(free_->at(cells), walls_.distances(cells, reach_));
}

std::vector<double> SaturatedSpeeds::fastest(const Blocks& blocks,
                                             const std::vector<Index>& numbers) const {
  return lowered(free_->fastest(blocks, numbers), walls_.farthest(blocks, numbers, reach_));
}

std::vector<double> SaturatedSpeeds::lowered(std::vector<double> free,
                                             const std::vector<double>& beside) const {
  for (std::size_t n = 0; n < free.size(); ++n) {
    const double own = beside[n] / reach_;
    if (own < saturation_) free[n] = std::min(free[n], own);
  }
  return free;
}

PassableSpeeds::PassableSpeeds(std::shared_ptr<const FreeSpeeds> free, Walls walls, double band,
                               double reach)
    : SpeedMap(free->cells(), free->outside()),
      free_(std::move(free)),
      walls_(std::move(walls)),
      around_(2.0 * band),
      reach_(reach) {
  const std::vector<Index> tube = free_->in_tube();
  const std::vector<double> speeds = free_->at(tube);
  std::vector<Index> deep;
  for (std::size_t n = 0; n < tube.size(); ++n)
    if (speeds[n] > free_->saturation() * (1.0 + kInTube)) deep.push_back(tube[n]);
  const std::vector<std::uint8_t> held = walls_.hold(deep);
  for (std::size_t n = 0; n < deep.size(); ++n)
    if (held[n] != 0) struck_.push_back(cells().centre(deep[n]));
}

std::vector<double> PassableSpeeds::at(const std::vector<Index>& cells) const {
  std::vector<double> beside = walls_.distances(cells, around_);
  for (double& each : beside) each /= around_;
  std::vector<Point> between;
  for (std::size_t n = 0; n < cells.size(); ++n)
    if (beside[n] > 0.0 && beside[n] < 1.0) between.push_back(this->cells().centre(cells[n]));
  const std::vector<bool> near = are_near_struck(between, 0.0);
  auto next = near.begin();
  const double saturation = free_->saturation();
  std::vector<double> speeds = free_->at(cells);
  for (std::size_t n = 0; n < cells.size(); ++n) {
    const double away = beside[n];
    const bool is_detour = away > 0.0 && away < 1.0 && *next++;
    const double closeness = is_detour ? 1.0 - std::abs(2.0 * away - 1.0) : 0.0;
    const double detour = std::max(speeds[n], saturation + (1.0 - saturation) * closeness);
    speeds[n] = detour * std::min(2.0 * away, 1.0);
  }
  return speeds;
}

std::vector<double> PassableSpeeds::fastest(const Blocks& blocks,
                                            const std::vector<Index>& numbers) const {
  const std::vector<double> nearest = walls_.nearest(blocks, numbers, around_);
  const std::vector<double> beside = walls_.farthest(blocks, numbers, around_);
  std::vector<Point> beside_walls;
  for (std::size_t n = 0; n < numbers.size(); ++n)
    if (nearest[n] < around_) beside_walls.push_back(blocks.centre(numbers[n]));
  const std::vector<bool> near = are_near_struck(beside_walls, blocks.reach);
  auto next = near.begin();
  std::vector<double> speeds = free_->fastest(blocks, numbers);
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    if (nearest[n] < around_ && *next++) speeds[n] = 1.0;
    speeds[n] *= std::min(2.0 * (beside[n] / around_), 1.0);
  }
  return speeds;
}

std::vector<bool> PassableSpeeds::are_near_struck(const std::vector<Point>& points,
                                                  double room) const {
  std::vector<bool> result(points.size(), false);
  if (struck_.empty()) return result;
  const double bound = (reach_ + room) * (1.0 + kRadiusRounding);
  const std::vector<double> away = path_distances(points, struck_, bound);
  std::transform(away.begin(), away.end(), result.begin(),
                 [&](double each) { return each < bound; });
  return result;
}

}  // namespace leadthrough
