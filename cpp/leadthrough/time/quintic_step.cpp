#include "leadthrough/time/quintic_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "leadthrough/base/constants.hpp"

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

JointState state(const Eigen::Ref<const Rows>& positions, const Eigen::Ref<const Rows>& velocities,
                 const Eigen::Ref<const Rows>& accelerations, Index row, Index joint) {
  return {positions(row, joint), velocities(row, joint), accelerations(row, joint)};
}

// Rows of MotionPeaks.
enum Peak : std::size_t { kLowest, kHighest, kSpeed, kAcceleration, kJerk, kPeaks };

// One joint's peaks so far. Smaller ones are not computed.
struct JointPeaks {
  std::array<double, kPeaks> value{kInfinity, -kInfinity, -1.0, -1.0, -1.0};
  std::array<double, kPeaks> time{};
  std::array<Index, kPeaks> step{};

  void look(const QuinticStep& quintic, double jerk, double begin, double end, Index at) {
    const auto note = [&](Peak peak, const Extreme& extreme, double side) {
      if (!(side * extreme.value > side * value[peak])) return;
      value[peak] = extreme.value;
      time[peak] = extreme.at < 1.0 ? begin + extreme.at * (end - begin) : end;
      step[peak] = at;
    };
    if (quintic.reach(-1.0) > -value[kLowest]) note(kLowest, quintic.lowest(), -1.0);
    if (quintic.reach(1.0) > value[kHighest]) note(kHighest, quintic.highest(), 1.0);
    if (quintic.speed_bound() > value[kSpeed]) note(kSpeed, quintic.speed(), 1.0);
    if (quintic.acceleration_bound() > value[kAcceleration])
      note(kAcceleration, quintic.acceleration(), 1.0);
    note(kJerk, {jerk, 0.5}, 1.0);
  }
};

}  // namespace

StepExtremes step_extremes(const Eigen::Ref<const Eigen::VectorXd>& times,
                           const Eigen::Ref<const Rows>& positions,
                           const Eigen::Ref<const Rows>& velocities,
                           const Eigen::Ref<const Rows>& accelerations) {
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

MotionPeaks motion_peaks(const Eigen::Ref<const Eigen::VectorXd>& times,
                         const Eigen::Ref<const Rows>& positions,
                         const Eigen::Ref<const Rows>& velocities,
                         const Eigen::Ref<const Rows>& accelerations) {
  const Index joints = positions.cols();
  std::vector<JointPeaks> peaks(static_cast<std::size_t>(joints));
  for (Index k = 0; k + 1 < times.size(); ++k) {
    const double duration = times[k + 1] - times[k];
    for (Index j = 0; j < joints; ++j) {
      const JointState start = state(positions, velocities, accelerations, k, j);
      const JointState end = state(positions, velocities, accelerations, k + 1, j);
      const double jerk = std::abs(end.acceleration - start.acceleration) / duration;
      peaks[static_cast<std::size_t>(j)].look(QuinticStep(duration, start, end), jerk, times[k],
                                              times[k + 1], k);
    }
  }
  MotionPeaks result{Rows(kPeaks, joints), Rows(kPeaks, joints), Rows(kPeaks, joints)};
  for (Index j = 0; j < joints; ++j)
    for (std::size_t row = 0; row < kPeaks; ++row) {
      const JointPeaks& peak = peaks[static_cast<std::size_t>(j)];
      const auto at = static_cast<Index>(row);
      result.value(at, j) = peak.value[row];
      result.time(at, j) = peak.time[row];
      result.step(at, j) = static_cast<double>(peak.step[row]);
    }
  return result;
}

}  // namespace leadthrough
