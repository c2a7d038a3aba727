#include "leadthrough/time/quintic_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

using Eigen::Index;

namespace {

// By how much a unit in the last place of both positions changes the middle coefficient of the
// velocity, times the duration, and how much more an inner coefficient of the acceleration.
constexpr double kPositionRounding = 10.0 * std::numeric_limits<double>::epsilon();
constexpr double kAccelerationRounding = 4.0;
constexpr int kMaxBisections = 80;

// De Casteljau's algorithm.
template <std::size_t size>
double bernstein(std::array<double, size> values, double u) {
  for (std::size_t left = size - 1; left > 0; --left)
    for (std::size_t i = 0; i < left; ++i) values[i] += u * (values[i + 1] - values[i]);
  return values[0];
}

// The fraction in a bracket at which a polynomial changes sign, by the Illinois false position.
template <std::size_t size>
double root(const std::array<double, size>& values, double low, double high) {
  double at_low = bernstein(values, low), at_high = bernstein(values, high);
  double middle = low;
  for (int k = 0; k < kMaxBisections && high - low > 0.0; ++k) {
    middle = low + (high - low) * at_low / (at_low - at_high);
    const double value = bernstein(values, middle);
    if (value == 0.0) break;
    if ((value > 0.0) == (at_low > 0.0)) {
      if (middle - low <= std::numeric_limits<double>::epsilon()) break;
      low = middle;
      at_low = value;
      at_high *= 0.5;
    } else {
      if (high - middle <= std::numeric_limits<double>::epsilon()) break;
      high = middle;
      at_high = value;
      at_low *= 0.5;
    }
  }
  return middle;
}

// Looks at the ends of the step and at inner places for the largest magnitude.
template <std::size_t size, typename Roots>
Extreme largest_at(const std::array<double, size>& values, double rounding, const Roots& inner) {
  Extreme result{std::abs(values.front()), 0.0};
  if (std::abs(values.back()) > result.value) result = {std::abs(values.back()), 1.0};
  for (std::size_t i = 0; i < inner.count; ++i) {
    const double value = std::abs(bernstein(values, inner.at[i])) - rounding;
    if (value > result.value) result = {value, inner.at[i]};
  }
  return result;
}

}  // namespace

std::array<double, 6> QuinticStep::position() const {
  std::array<double, 6> result{};
  result[0] = start_;
  for (std::size_t i = 0; i < 2; ++i) result[i + 1] = result[i] + 0.2 * duration_ * velocity_[i];
  result[5] = end_;
  for (std::size_t i = 5; i > 3; --i)
    result[i - 1] = result[i] - 0.2 * duration_ * velocity_[i - 1];
  return result;
}

double QuinticStep::rounding() const {
  return kPositionRounding * std::max(std::abs(start_), std::abs(end_)) / duration_;
}

Extreme QuinticStep::speed() const {
  const bool at_ends =
      speed_bound() <= std::max(std::abs(velocity_.front()), std::abs(velocity_.back()));
  return largest_at(velocity_, rounding(), at_ends ? Roots{} : acceleration_roots());
}

Extreme QuinticStep::acceleration() const {
  const bool at_ends = acceleration_bound() <=
                       std::max(std::abs(acceleration_.front()), std::abs(acceleration_.back()));
  return largest_at(acceleration_, kAccelerationRounding * rounding() / duration_,
                    at_ends ? Roots{} : jerk_roots());
}

Extreme QuinticStep::position_extreme(double side) const {
  Extreme result{start_, 0.0};
  if (side * end_ > side * result.value) result = {end_, 1.0};
  const Roots inner = velocity_roots();
  if (inner.count == 0) return result;
  const std::array<double, 6> values = position();
  for (std::size_t i = 0; i < inner.count; ++i) {
    const double value = bernstein(values, inner.at[i]);
    if (side * value > side * result.value) result = {value, inner.at[i]};
  }
  return result;
}

QuinticStep::Roots QuinticStep::jerk_roots() const {
  const double d0 = acceleration_[1] - acceleration_[0], d1 = acceleration_[2] - acceleration_[1],
               d2 = acceleration_[3] - acceleration_[2];
  const double a = d0 - 2.0 * d1 + d2, half = d1 - d0, discriminant = half * half - a * d0;
  Roots roots;
  if (!(discriminant >= 0.0)) return roots;
  const double sum = -(half + std::copysign(std::sqrt(discriminant), half));
  for (const auto& [above, below] : {std::pair(sum, a), std::pair(d0, sum)}) {
    const double u = above / below;
    if (u > 0.0 && u < 1.0) roots.at[roots.count++] = u;
  }
  if (roots.count == 2 && roots.at[0] > roots.at[1]) std::swap(roots.at[0], roots.at[1]);
  return roots;
}

namespace {

// A polynomial lies between its coefficients: where none differs in sign, nor does it.
template <std::size_t size>
bool one_sign(const std::array<double, size>& values) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return *least >= 0.0 || *most <= 0.0;
}

// Roots of a polynomial that is monotonic between its derivative's roots.
template <std::size_t size, typename Roots>
Roots between(const std::array<double, size>& values, const Roots& turns) {
  Roots roots;
  double low = 0.0, at_low = values.front();
  for (std::size_t i = 0; i <= turns.count; ++i) {
    const double high = i < turns.count ? turns.at[i] : 1.0, at_high = bernstein(values, high);
    if ((at_low > 0.0) != (at_high > 0.0)) roots.at[roots.count++] = root(values, low, high);
    low = high;
    at_low = at_high;
  }
  return roots;
}

}  // namespace

QuinticStep::Roots QuinticStep::acceleration_roots() const {
  return one_sign(acceleration_) ? Roots{} : between(acceleration_, jerk_roots());
}

QuinticStep::Roots QuinticStep::velocity_roots() const {
  return one_sign(velocity_) ? Roots{} : between(velocity_, acceleration_roots());
}

namespace {

JointState state(const RowsRef& positions, const RowsRef& velocities, const RowsRef& accelerations,
                 Index row, Index joint) {
  return {positions(row, joint), velocities(row, joint), accelerations(row, joint)};
}

// Rows of MotionPeaks.
enum Peak : Index { kLowest, kHighest, kSpeed, kAcceleration, kJerk, kPeaks };

// Peaks so far of joints at once. Smaller ones are not computed.
struct LanePeaks {
  std::array<Lanes, kPeaks> value, time, step;

  LanePeaks() {
    for (Index row = 0; row < kPeaks; ++row) {
      value[row].fill(-1.0);
      time[row].fill(0.0);
      step[row].fill(0.0);
    }
    value[kLowest].fill(kInfinity);
    value[kHighest].fill(-kInfinity);
  }

  void look(const LaneStates& start, const LaneStates& end, double begin, double finish, Index at) {
    const double duration = finish - begin;
    const LaneBounds bounds(duration, start, end);
    const Lanes speed = bounds.speed.max(start.velocity.abs());
    const Lanes acceleration = bounds.acceleration.max(start.acceleration.abs());
    const Lanes jerk = (end.acceleration - start.acceleration).abs() / duration;
    const Lanes high = start.position.max(end.position) + duration * speed,
                low = start.position.min(end.position) - duration * speed;
    const Lanes beyond = (high - value[kHighest])
                             .max(value[kLowest] - low)
                             .max(speed - value[kSpeed])
                             .max(acceleration - value[kAcceleration])
                             .max(jerk - value[kJerk]);
    if (beyond.maxCoeff() <= 0.0) return;
    for (Index lane = 0; lane < kLanes; ++lane) {
      if (!(beyond[lane] > 0.0)) continue;
      const QuinticStep quintic(duration, start.joint(lane), end.joint(lane));
      const auto note = [&](Peak peak, const Extreme& extreme, double side) {
        if (!(side * extreme.value > side * value[peak][lane])) return;
        value[peak][lane] = extreme.value;
        time[peak][lane] = extreme.at < 1.0 ? begin + extreme.at * duration : finish;
        step[peak][lane] = static_cast<double>(at);
      };
      if (low[lane] < value[kLowest][lane]) note(kLowest, quintic.lowest(), -1.0);
      if (high[lane] > value[kHighest][lane]) note(kHighest, quintic.highest(), 1.0);
      if (speed[lane] > value[kSpeed][lane]) note(kSpeed, quintic.speed(), 1.0);
      if (acceleration[lane] > value[kAcceleration][lane])
        note(kAcceleration, quintic.acceleration(), 1.0);
      note(kJerk, {jerk[lane], 0.5}, 1.0);
    }
  }
};

void check_samples(const VectorRef& times, const RowsRef& positions, const RowsRef& velocities,
                   const RowsRef& accelerations) {
  check_argument(times.size() > 1, "times: expected at least two");
  for (const auto* rows : {&positions, &velocities, &accelerations})
    check_argument(rows->rows() == times.size() && rows->cols() == positions.cols(),
                   "states: expected one row for each time, one column a joint");
}

}  // namespace

StepExtremes step_extremes(const VectorRef& times, const RowsRef& positions,
                           const RowsRef& velocities, const RowsRef& accelerations) {
  check_samples(times, positions, velocities, accelerations);
  const Index steps = times.size() - 1, joints = positions.cols();
  StepExtremes result{Rows(steps, joints), Rows(steps, joints)};
  for (Index k = 0; k < steps; ++k)
    for (Index j = 0; j < joints; ++j) {
      const QuinticStep step(times[k + 1] - times[k],
                             state(positions, velocities, accelerations, k, j),
                             state(positions, velocities, accelerations, k + 1, j));
      result.speed(k, j) = step.speed().value;
      result.acceleration(k, j) = step.acceleration().value;
    }
  return result;
}

MotionPeaks motion_peaks(const VectorRef& times, const RowsRef& positions,
                         const RowsRef& velocities, const RowsRef& accelerations) {
  check_samples(times, positions, velocities, accelerations);
  const Index joints = positions.cols();
  MotionPeaks result{Rows(kPeaks, joints), Rows(kPeaks, joints), Rows(kPeaks, joints)};
  for (Index first = 0; first < joints; first += kLanes) {
    const Index count = std::min(kLanes, joints - first);
    LanePeaks peaks;
    const auto at = [&](Index k) {
      LaneStates states;
      states.position.head(count) = positions.row(k).segment(first, count).transpose().array();
      states.velocity.head(count) = velocities.row(k).segment(first, count).transpose().array();
      states.acceleration.head(count) =
          accelerations.row(k).segment(first, count).transpose().array();
      return states;
    };
    LaneStates start = at(0), end;
    for (Index k = 0; k + 1 < times.size(); ++k, start = end) {
      check_interrupt(k);
      end = at(k + 1);
      peaks.look(start, end, times[k], times[k + 1], k);
    }
    for (Index lane = 0; lane < count; ++lane)
      for (Index row = 0; row < kPeaks; ++row) {
        result.value(row, first + lane) = peaks.value[row][lane];
        result.time(row, first + lane) = peaks.time[row][lane];
        result.step(row, first + lane) = peaks.step[row][lane];
      }
  }
  return result;
}

}  // namespace leadthrough
