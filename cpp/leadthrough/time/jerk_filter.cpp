// Let the stop of a state be its fastest way to rest, and D where that ends. Ways of velocity and
// acceleration alone ("ramps": push, hold, release) are optimal as for a double integrator.
//
// The law: while D lies before the target, ramp towards the highest velocity; from the moment at
// which D is the target, stop. Behind the target, the same mirrored. It needs nothing but the
// state, and is the time-optimal one (Castain and Paul 1984; Haschke et al. 2008).
//
// Along the ramp D never decreases: dD/dt = (ramp's jerk - stop's jerk) dD/da, where dD/da >= 0, as
// of two stops the one that starts with more acceleration has the higher velocity throughout, and
// where the ramp's jerk is not the stop's, it is larger. So the moment is found by bisection and
// the target is never passed but by states that cannot help it. If both jerks agree, D differs
// from the target by rounding only, without any consequence: nothing chatters.

#include "leadthrough/time/jerk_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

// Places so near, relative to the numbers they are sums of, are one.
constexpr double kSamePlace = 16.0 * std::numeric_limits<double>::epsilon();
constexpr int kMaxSteps = 200;

AxisLimits mirrored(const AxisLimits& l) {
  return {-l.velocity_high,    -l.velocity_low, -l.acceleration_high,
          -l.acceleration_low, -l.jerk_high,    -l.jerk_low};
}

JointState mirrored(const JointState& s) { return {-s.position, -s.velocity, -s.acceleration}; }

// To a velocity without acceleration: times and jerks of the three parts, accelerations after them.
struct Ramp {
  std::array<double, 3> time, jerk, acceleration;
  double velocity;
  double duration() const { return time[0] + time[1] + time[2]; }
};

// The ramp if the acceleration, released at once, leaves less than `velocity`.
Ramp ramp_up(const JointState& s, double velocity, const AxisLimits& limits) {
  const double push = limits.jerk_high, release = -limits.jerk_low;
  const double most = limits.acceleration_high, a = s.acceleration, change = velocity - s.velocity;
  const double released = 0.5 * most * most / release;
  if (a > most) {  // outside of the limits
    const double back = 0.5 * (a * a - most * most) / release;
    const double hold = std::max(0.0, (change - back - released) / most);
    return {{(a - most) / release, hold, most / release},
            {-release, 0.0, -release},
            {most, most, 0.0},
            velocity};
  }
  const double pushed = change + 0.5 * a * a / push;
  double peak = std::sqrt(std::max(0.0, 2.0 * pushed * push * release / (push + release)));
  peak = std::max(peak, a);
  double hold = 0.0;
  if (peak > most) {
    peak = most;
    hold = std::max(0.0, (pushed - 0.5 * most * most / push - released) / most);
  }
  return {{(peak - a) / push, hold, peak / release},
          {push, 0.0, -release},
          {peak, peak, 0.0},
          velocity};
}

Ramp ramp_to(double velocity, const JointState& s, const AxisLimits& limits) {
  const double a = s.acceleration;
  const double jerk = a > 0.0 ? limits.jerk_low : limits.jerk_high;
  if (velocity >= s.velocity - 0.5 * a * a / jerk) return ramp_up(s, velocity, limits);
  Ramp ramp = ramp_up(mirrored(s), -velocity, mirrored(limits));
  for (std::size_t i = 0; i < 3; ++i) {
    ramp.jerk[i] = -ramp.jerk[i];
    ramp.acceleration[i] = -ramp.acceleration[i];
  }
  ramp.velocity = velocity;
  return ramp;
}

void push(JointState& s, double jerk, double t) {
  s.position += t * (s.velocity + t * (0.5 * s.acceleration + t * jerk / 6.0));
  s.velocity += t * (s.acceleration + 0.5 * t * jerk);
  s.acceleration += t * jerk;
}

JointState end_of(const Ramp& ramp, JointState s) {
  for (std::size_t i = 0; i < 3; ++i) {
    push(s, ramp.jerk[i], ramp.time[i]);
    s.acceleration = ramp.acceleration[i];  // free of rounding, which would leave the limits
  }
  s.velocity = ramp.velocity;
  return s;
}

// After a time on the ramp and, where that is over, at its velocity.
JointState after(double time, const Ramp& ramp, JointState s) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (time < ramp.time[i]) {
      push(s, ramp.jerk[i], time);
      return s;
    }
    push(s, ramp.jerk[i], ramp.time[i]);
    s.acceleration = ramp.acceleration[i];
    time -= ramp.time[i];
  }
  s.velocity = ramp.velocity;
  s.position += time * s.velocity;
  return s;
}

Ramp stop_of(const JointState& s, const AxisLimits& limits) { return ramp_to(0.0, s, limits); }

// A number between `low` and `high` at which a rising function, negative at `low`, is zero or less
// by no more than `nearly`; a lower one where rounding leaves none. Regula falsi (Illinois), aimed
// at the middle of what is asked for, with every third step a bisection, so that it ends.
template <typename Function>
double last_not_positive(const Function& f, double low, double high, double nearly) {
  const double aim = -0.5 * nearly;
  double below = f(low) - aim, above = f(high) - aim;
  int side = 0;
  for (int i = 1; i <= kMaxSteps; ++i) {
    const double half = 0.5 * (low + high);
    double middle = low - below * (high - low) / (above - below);
    if (i % 3 == 0 || !(middle > low && middle < high)) middle = half;
    if (!(middle > low && middle < high)) break;
    const double value = f(middle) - aim;
    if (std::abs(value) <= -aim) return middle;
    if (value < 0.0) {
      if (side < 0) above *= 0.5;
      side = -1;
      low = middle;
      below = value;
    } else {
      if (side > 0) below *= 0.5;
      side = 1;
      high = middle;
      above = value;
    }
  }
  return low;
}

// An axis on its way up to the target, which is the origin.
class Approach {
 public:
  Approach(const JointState& state, double target, const AxisLimits& limits)
      : s_{state.position - target, state.velocity, state.acceleration},
        limits_(limits),
        rest_(rest(s_)) {
    nearly_ = kSamePlace * (std::abs(state.position) + std::abs(target) + std::abs(rest_));
    if (rest_ <= nearly_) return;
    mirrored_ = true;
    s_ = mirrored(s_);
    limits_ = mirrored(limits_);
    rest_ = -rest_;
  }

  double time() const { return time_with(limits_.velocity_high); }

  JointState step(double period) const { return step(period, limits_.velocity_high); }

  JointState step_at(double period, double time) const { return step(period, speed_for(time)); }

  // Seen from where the target is not the origin.
  JointState placed(JointState s, double target) const {
    if (mirrored_) s = mirrored(s);
    return {target + s.position, s.velocity, s.acceleration};
  }

 private:
  bool stops() const { return rest_ >= -nearly_; }
  Ramp stop(const JointState& s) const { return stop_of(s, limits_); }
  double rest(const JointState& s) const { return end_of(stop(s), s).position; }

  JointState step(double period, double speed) const {
    double moment = 0.0;
    JointState s = s_;
    if (!stops()) {
      const Ramp ramp = ramp_to(speed, s_, limits_);
      s = after(period, ramp, s_);
      if (rest(s) <= 0.0) return s;
      moment = last_moment(ramp, period);
      s = after(moment, ramp, s_);
    }
    const Ramp ramp = stop(s);
    if (period - moment >= ramp.duration()) return {0.0, 0.0, 0.0};
    return after(period - moment, ramp, s);
  }

  // The last time on the ramp, before `late`, from which the axis can stop at the origin.
  double last_moment(const Ramp& ramp, double late) const {
    return last_not_positive([&](double t) { return rest(after(t, ramp, s_)); }, 0.0, late,
                             0.25 * nearly_);
  }

  // Until the axis is at rest if no speed above this one is ramped to.
  double time_with(double speed) const {
    if (stops()) return stop(s_).duration();
    const Ramp ramp = ramp_to(speed, s_, limits_);
    const JointState fast = end_of(ramp, s_);
    const double left = -rest(fast);
    if (left >= 0.0) return ramp.duration() + left / speed + stop(fast).duration();
    const double last = last_moment(ramp, ramp.duration());
    return last + stop(after(last, ramp, s_)).duration();
  }

  // The speed with which the way takes a time, the highest where it takes no less anyway: the lower
  // the speed, the later the axis comes.
  double speed_for(double wanted) const {
    const double highest = limits_.velocity_high;
    if (stops() || time() >= wanted) return highest;
    double low = highest;
    for (int i = 0; i < kMaxSteps && time_with(low) < wanted; ++i) low *= 0.5;
    const auto early = [&](double speed) { return wanted - time_with(speed); };
    return last_not_positive(early, low, std::min(2.0 * low, highest), kSamePlace * wanted);
  }

  JointState s_;
  AxisLimits limits_;
  double rest_ = 0.0, nearly_ = 0.0;
  bool mirrored_ = false;
};

class Axes {
 public:
  Axes(const RowsRef& states, const RowsRef& limits, Eigen::Index targets)
      : states_(states), limits_(limits) {
    check_argument(states.rows() == 3 && limits.rows() == 6 && limits.cols() == states.cols(),
                   "states, limits: expected three and six rows, one column an axis");
    check_argument(targets == size(), "targets: expected one for each axis");
  }

  Eigen::Index size() const { return states_.cols(); }
  JointState state(Eigen::Index i) const { return {states_(0, i), states_(1, i), states_(2, i)}; }
  AxisLimits limit(Eigen::Index i) const {
    return {limits_(0, i), limits_(1, i), limits_(2, i),
            limits_(3, i), limits_(4, i), limits_(5, i)};
  }

 private:
  const RowsRef &states_, &limits_;
};

template <typename Step>
Rows stepped(const Axes& axes, const VectorRef& targets, const Step& step) {
  Rows result(3, axes.size());
  for (Eigen::Index i = 0; i < axes.size(); ++i) {
    check_interrupt(i);
    const Approach approach(axes.state(i), targets[i], axes.limit(i));
    const JointState s = approach.placed(step(approach), targets[i]);
    result.col(i) << s.position, s.velocity, s.acceleration;
  }
  return result;
}

}  // namespace

Eigen::VectorXd resting_places(const RowsRef& states, const RowsRef& limits) {
  const Axes axes(states, limits, states.cols());
  Eigen::VectorXd places(axes.size());
  for (Eigen::Index i = 0; i < axes.size(); ++i) {
    check_interrupt(i);
    places[i] = end_of(stop_of(axes.state(i), axes.limit(i)), axes.state(i)).position;
  }
  return places;
}

Eigen::VectorXd times_to_rest(const RowsRef& states, const RowsRef& limits,
                              const VectorRef& targets) {
  const Axes axes(states, limits, targets.size());
  Eigen::VectorXd times(axes.size());
  for (Eigen::Index i = 0; i < axes.size(); ++i) {
    check_interrupt(i);
    times[i] = Approach(axes.state(i), targets[i], axes.limit(i)).time();
  }
  return times;
}

JointState step_axis(const JointState& state, double target, const AxisLimits& limits,
                     double period) {
  const Approach approach(state, target, limits);
  return approach.placed(approach.step(period), target);
}

Rows step_each(const RowsRef& states, const RowsRef& limits, const VectorRef& targets,
               double period) {
  return stepped({states, limits, targets.size()}, targets,
                 [&](const Approach& axis) { return axis.step(period); });
}

Rows step_together(const RowsRef& states, const RowsRef& limits, const VectorRef& targets,
                   double period) {
  const Eigen::VectorXd times = times_to_rest(states, limits, targets);
  const double last = times.size() > 0 ? times.maxCoeff() : 0.0;
  return stepped({states, limits, targets.size()}, targets,
                 [&](const Approach& axis) { return axis.step_at(period, last); });
}

}  // namespace leadthrough
