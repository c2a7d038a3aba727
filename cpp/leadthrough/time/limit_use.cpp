#include "leadthrough/time/limit_use.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/time/quintic_step.hpp"

namespace leadthrough {

using Eigen::Index;

namespace {

constexpr Index kOrders = 3;

// One joint's samples as they come.
struct Track {
  JointState last{};
  double slope = 0.0, bend = 0.0;  // the last differences of the positions, of orders 1 and 2
};

// By how many times a joint exceeds its limits in the step to a sample, and 0 for those that it
// keeps; `known` samples came before it.
std::array<double, 3> step_excess(Track& track, const JointState& now, Index known, double step,
                                  bool between, const std::array<double, 3>& limits) {
  std::array<double, 3> result{};
  const double slope = now.position - track.last.position, bend = slope - track.slope;
  if (known == 0 || !between) {
    result[0] = std::abs(now.velocity);
    result[1] = std::abs(now.acceleration);
  } else {
    const QuinticStep quintic(step, track.last, now);
    const double speed = quintic.speed_bound(), acceleration = quintic.acceleration_bound();
    if (speed > limits[0]) result[0] = quintic.speed().value;
    if (acceleration > limits[1]) result[1] = quintic.acceleration().value;
    if (known >= kOrders) result[2] = std::abs(bend - track.bend) / (step * step * step);
  }
  if (known > 0)
    result[2] = std::max(result[2], std::abs(now.acceleration - track.last.acceleration) / step);
  for (std::size_t order = 0; order < 3; ++order)
    result[order] = result[order] > limits[order] ? result[order] / limits[order] : 0.0;
  track = {now, slope, bend};
  return result;
}

}  // namespace

void measure_use(const PolynomialPath& path, const PathGrid& grid, const RateLimits& limits,
                 const LawSamples& law, const Judged& judged, LimitRatios& ratios) {
  const Index joints = path.joints(), samples = static_cast<Index>(law.size());
  const double step = judged.period * static_cast<double>(judged.parts);
  std::vector<Track> tracks(static_cast<std::size_t>(joints));
  for (auto& order : ratios.each) order.assign(law.size(), 0.0);
  ratios.largest.fill(0.0);
  PathStates states(path, grid);
  const Index inner = judged.rests_at_end ? (samples + judged.parts - 2) / judged.parts
                                          : (samples - 1) / judged.parts;
  const Index first = judged.rests_at_start ? -kOrders : 0;
  const Index last = inner + (judged.rests_at_end ? kOrders : 0);
  for (Index k = first; k <= last; ++k) {
    const auto at = static_cast<std::size_t>(std::clamp<Index>(k * judged.parts, 0, samples - 1));
    states.move_to(law.length[at], law.speed[at], law.push[at]);
    for (Index j = 0; j < joints; ++j) {
      if (limits.velocity[j] == 0.0) continue;  // does not move
      const auto used = step_excess(
          tracks[static_cast<std::size_t>(j)],
          {states.position()[j], states.velocity()[j], states.acceleration()[j]}, k - first, step,
          judged.between, {limits.velocity[j], limits.acceleration[j], limits.jerk[j]});
      for (std::size_t order = 0; order < 3; ++order) {
        if (used[order] == 0.0) continue;
        ratios.each[order][at] = std::max(ratios.each[order][at], used[order]);
        ratios.largest[order] = std::max(ratios.largest[order], used[order]);
      }
    }
  }
}

}  // namespace leadthrough
