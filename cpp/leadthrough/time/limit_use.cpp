#include "leadthrough/time/limit_use.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/time/quintic_step.hpp"

namespace leadthrough {

using Eigen::Index;

namespace {

constexpr Index kOrders = 3;

// A sample of some joints, with its differences of positions, of orders 1 and 2, to those before.
struct Sample : LaneStates {
  Lanes slope = Lanes::Zero(), bend = Lanes::Zero();
};

// Samples of up to kLanes joints as they come.
class JointGroup {
 public:
  JointGroup(const RateLimits& limits, const Judged& judged, Index first)
      : judged_(judged),
        step_(judged.period * static_cast<double>(judged.parts)),
        first_(first),
        joints_(std::min(kLanes, limits.velocity.size() - first)) {
    for (std::size_t order = 0; order < 3; ++order) limits_[order].fill(kInfinity);
    for (Index lane = 0; lane < joints_; ++lane) {
      const Index j = first + lane;
      if (limits.velocity[j] == 0.0) continue;  // does not move
      for (const auto& [order, each] :
           {std::pair(0U, &limits.velocity), std::pair(1U, &limits.acceleration),
            std::pair(2U, &limits.jerk)})
        limits_[order][lane] = (1.0 + kAllowedExcess) * (*each)[j];
    }
  }

  // The next sample, of which `known` came before, and by how many times joints exceed their limits
  // in the step to it; not told of those that keep them.
  template <typename Note>
  void add(const PathStates& states, Index known, const Note& note) {
    Sample now;
    now.position.head(joints_) = states.position().segment(first_, joints_).array();
    now.velocity.head(joints_) = states.velocity().segment(first_, joints_).array();
    now.acceleration.head(joints_) = states.acceleration().segment(first_, joints_).array();
    now.slope = now.position - last_.position;
    now.bend = now.slope - last_.slope;
    const Lanes beyond = known < kOrders ? Lanes(Lanes::Ones()) : bound_beyond(now);
    if (beyond.maxCoeff() > 0.0)
      for (Index lane = 0; lane < joints_; ++lane)
        if (beyond[lane] > 0.0) note(excess(now, lane, known));
    last_ = now;
  }

 private:
  // Positive where a bound of the quintics or of the differences exceeds a limit. The sample before
  // had its own.
  Lanes bound_beyond(const Sample& now) const {
    const LaneBounds bounds(step_, last_, now);
    const Lanes jerk = ((1.0 / step_) * (now.acceleration - last_.acceleration).abs())
                           .max((1.0 / (step_ * step_ * step_)) * (now.bend - last_.bend).abs());
    return (bounds.speed - limits_[0]).max(bounds.acceleration - limits_[1]).max(jerk - limits_[2]);
  }

  std::array<double, 3> excess(const Sample& now, Index lane, Index known) const {
    const JointState before = last_.joint(lane), after = now.joint(lane);
    std::array<double, 3> result{};
    if (known == 0 || !judged_.between) {
      result[0] = std::abs(after.velocity);
      result[1] = std::abs(after.acceleration);
    } else {
      const QuinticStep quintic(step_, before, after);
      if (quintic.speed_bound() > limits_[0][lane]) result[0] = quintic.speed().value;
      if (quintic.acceleration_bound() > limits_[1][lane]) result[1] = quintic.acceleration().value;
      if (known >= kOrders)
        result[2] = std::abs(now.bend[lane] - last_.bend[lane]) / (step_ * step_ * step_);
    }
    if (known > 0)
      result[2] = std::max(result[2], std::abs(after.acceleration - before.acceleration) / step_);
    for (std::size_t order = 0; order < 3; ++order) {
      const double limit = limits_[order][lane];
      result[order] = result[order] > limit ? result[order] / limit * (1.0 + kAllowedExcess) : 0.0;
    }
    return result;
  }

  const Judged judged_;
  const double step_;
  const Index first_, joints_;
  std::array<Lanes, 3> limits_;  // with what is allowed beyond them
  Sample last_;
};

}  // namespace

std::size_t LawSamples::same_as(const LawSamples& other) const {
  const std::size_t count = std::min(size(), other.size());
  std::size_t k = 0;
  while (k < count && length[k] == other.length[k] && speed[k] == other.speed[k] &&
         push[k] == other.push[k])
    ++k;
  return k;
}

void measure_use(const PolynomialPath& path, const PathGrid& grid, const RateLimits& limits,
                 const LawSamples& law, const Judged& judged, std::size_t same,
                 LimitRatios& ratios) {
  const Index samples = static_cast<Index>(law.size());
  std::vector<JointGroup> groups;
  for (Index j = 0; j < path.joints(); j += kLanes) groups.emplace_back(limits, judged, j);
  PathStates states(path, grid);
  const Index inner = judged.rests_at_end ? (samples + judged.parts - 2) / judged.parts
                                          : (samples - 1) / judged.parts;
  const Index last = inner + (judged.rests_at_end ? kOrders : 0);
  const Index start = judged.rests_at_start ? -kOrders : 0;
  // The same samples are measured; those before the first other one make differences.
  const Index other = same == 0 ? start : (static_cast<Index>(same) - 1) / judged.parts + 1;
  const Index first = std::max(start, other - kOrders);
  for (auto& order : ratios.each) {
    order.resize(
        std::min(law.size(), static_cast<std::size_t>(std::max<Index>(other, 0) * judged.parts)));
    order.resize(law.size(), 0.0);
  }
  for (Index k = first; k <= last; ++k) {
    check_interrupt(k);
    const auto at = static_cast<std::size_t>(std::clamp<Index>(k * judged.parts, 0, samples - 1));
    states.move_to(law.length[at], law.speed[at], law.push[at]);
    const auto note = [&](const std::array<double, 3>& used) {
      for (std::size_t order = 0; order < 3 && k >= other; ++order)
        ratios.each[order][at] = std::max(ratios.each[order][at], used[order]);
    };
    for (JointGroup& group : groups) group.add(states, k - first, note);
  }
  for (std::size_t order = 0; order < 3; ++order)
    ratios.largest[order] = *std::max_element(ratios.each[order].begin(), ratios.each[order].end());
}

}  // namespace leadthrough
