#include "leadthrough/guard/brake.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "leadthrough/base/interrupt.hpp"

namespace leadthrough::guard {

namespace {

using Eigen::Index;

// Maximum steps to rest; no arm needs as many.
constexpr Index kMaxSteps = Index{1} << 24;
// An acceleration within this of a multiple of the jerk limit, relative to it, counts as equal.
constexpr double kSame = 1e-9;

// A joint, mirrored so that it must decelerate.
struct Joint {
  double velocity = 0.0, acceleration = 0.0;
  double most = 0.0;  // acceleration
  double jerk = 0.0;

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
  return static_cast<Index>(std::clamp(steps, 0.0, static_cast<double>(kMaxSteps)));
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
    check_interrupt();
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

// A joint's motion, after each of its steps. Per period.
class Motion {
 public:
  Motion(const JointState& start, double most, double jerk, double period)
      : now_{start.position, start.velocity * period, start.acceleration * period * period} {
    if (now_.velocity == 0.0 && now_.acceleration == 0.0) return;
    stop_ = stop_of({now_.velocity + 0.5 * now_.acceleration, now_.acceleration, most, jerk});
    steps_ = stop_.steps + 1;
  }

  Index steps() const { return steps_; }

  const JointState& after(Index i) {
    if (i > steps_) return now_;
    const double next = i < steps_ ? stop_.acceleration(i) : 0.0;
    now_.position += now_.velocity + now_.acceleration / 3.0 + next / 6.0;
    now_.velocity = i < steps_ ? now_.velocity + 0.5 * (now_.acceleration + next) : 0.0;
    now_.acceleration = next;
    return now_;
  }

 private:
  JointState now_;
  Stop stop_;
  Index steps_ = 0;
};

}  // namespace

Rows brake(const StepLimits& limits, const RowsRef& start) {
  check_start(limits, start);
  const double h = limits.period;
  std::vector<Motion> motions;
  Index longest = 0;
  for (Index j = 0; j < limits.joints(); ++j) {
    motions.emplace_back(joint_state(start, 0, j), limits.acceleration[j] * h * h,
                         limits.jerk[j] * h * h * h, h);
    longest = std::max(longest, motions.back().steps());
  }
  Rows samples(longest, start.cols());
  for (Index i = 1; i <= longest; ++i)
    for (Index j = 0; j < limits.joints(); ++j) {
      check_interrupt();
      const JointState& now = motions[static_cast<std::size_t>(j)].after(i);
      put({now.position, now.velocity / h, now.acceleration / (h * h)}, j, samples.row(i - 1));
    }
  return samples;
}

}  // namespace leadthrough::guard
