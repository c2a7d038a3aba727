#include "leadthrough/guard/brake.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace leadthrough::guard {

namespace {

using Eigen::Index;

// Maximum steps to rest; no arm needs as many.
constexpr Index kMaxSteps = Index{1} << 24;
// An acceleration within this of a multiple of the jerk limit, relative to it, counts as equal.
constexpr double kSame = 1e-9;

// A joint, mirrored so that it must decelerate.
struct Joint {
  double velocity, acceleration;
  double most;  // acceleration
  double jerk;

  Joint mirrored() const { return {-velocity, -acceleration, most, jerk}; }

  double low(Index i, Index steps) const {
    return std::max({acceleration - static_cast<double>(i) * jerk, -most,
                     -static_cast<double>(steps + 1 - i) * jerk});
  }
};

double triangle(double count) { return 0.5 * count * (count + 1.0); }

// low_1 + ... + low_steps: count of steps in each of the three cases, and their sums.
double lowest_sum(const Joint& joint, Index steps) {
  const double m = static_cast<double>(steps);
  const double down = std::floor(std::min((joint.acceleration + joint.most) / joint.jerk,
                                          0.5 * (joint.acceleration / joint.jerk + m + 1.0)));
  const double falling = std::clamp(down, 0.0, m);
  const double rising = std::clamp(std::floor(joint.most / joint.jerk), 0.0, m - falling);
  const double held = m - falling - rising;
  return falling * joint.acceleration - joint.jerk * triangle(falling) - joint.most * held -
         joint.jerk * triangle(rising);
}

// The fewest steps in which the acceleration can end; the first one is 0.
Index steps_to_release(const Joint& joint) {
  const double steps = std::ceil(std::abs(joint.acceleration) / joint.jerk - kSame) - 1.0;
  return static_cast<Index>(std::max(0.0, steps));
}

// The fewest steps, above `few`, whose lowest sum is at most `sum`.
Index steps_for(const Joint& joint, double sum, Index few) {
  Index enough = few + 1;
  while (lowest_sum(joint, enough) > sum && enough < kMaxSteps) {
    few = enough;
    enough *= 2;
  }
  while (enough - few > 1) {
    const Index middle = few + (enough - few) / 2;
    (lowest_sum(joint, middle) > sum ? few : enough) = middle;
  }
  return enough;
}

// Accelerations to rest are a mean: `share` times the first ones, which have a step less, plus
// 1 - `share` times the second ones.
struct Stop {
  Joint joint;
  Index steps = 0;
  bool mirrored = false;
  bool released = false;  // the mean is of the lowest and the highest of the same steps
  double share = 0.0;

  double first(Index i) const {
    if (released) return -joint.mirrored().low(i, steps);
    return i < steps ? joint.low(i, steps - 1) : 0.0;
  }
  double acceleration(Index i) const {
    const double value = share * first(i) + (1.0 - share) * joint.low(i, steps);
    return mirrored ? -value : value;
  }
};

Stop with_share(Stop stop) {
  double first = 0.0, second = 0.0;
  for (Index i = 1; i <= stop.steps; ++i) {
    first += stop.first(i);
    second += stop.joint.low(i, stop.steps);
  }
  const double between = first - second;
  if (between > 0.0) stop.share = std::clamp((-stop.joint.velocity - second) / between, 0.0, 1.0);
  return stop;
}

Stop stop_of(const Joint& joint) {
  const Index release = steps_to_release(joint);
  const double low = lowest_sum(joint, release);
  const double high = -lowest_sum(joint.mirrored(), release);
  if (-joint.velocity < low) return with_share({joint, steps_for(joint, -joint.velocity, release)});
  if (-joint.velocity <= high) return with_share({joint, release, false, true});
  const Joint other = joint.mirrored();
  return with_share({other, steps_for(other, -other.velocity, release), true});
}

}  // namespace

Rows brake(const StepLimits& limits, const RowsRef& history) {
  const Index joints = limits.joints();
  std::vector<Stop> stops;
  Index longest = 0;
  for (Index j = 0; j < joints; ++j) {
    const double velocity = history(2, j) - history(1, j);
    const double before = history(1, j) - history(0, j);
    stops.push_back(stop_of({velocity, velocity - before, limits.bend[j], limits.twist[j]}));
    longest = std::max(longest, stops.back().steps);
  }
  Rows samples(longest, joints);
  for (Index j = 0; j < joints; ++j) {
    const Stop& stop = stops[static_cast<std::size_t>(j)];
    double position = history(2, j), velocity = position - history(1, j);
    for (Index i = 1; i <= longest; ++i) {
      if (i <= stop.steps) {
        velocity += stop.acceleration(i);
        position += velocity;
      }
      samples(i - 1, j) = position;
    }
  }
  return samples;
}

}  // namespace leadthrough::guard
