#include "time/quintic_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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

template <std::size_t size>
double largest(const std::array<double, size>& values) {
  double result = 0.0;
  for (const double value : values) result = std::max(result, std::abs(value));
  return result;
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

QuinticStep::QuinticStep(double duration, const JointState& start, const JointState& end)
    : rounding_(kPositionRounding * std::max(std::abs(start.position), std::abs(end.position)) /
                duration),
      duration_(duration) {
  const double h = duration;
  velocity_ = {start.velocity, start.velocity + 0.25 * h * start.acceleration, 0.0,
               end.velocity - 0.25 * h * end.acceleration, end.velocity};
  velocity_[2] = 5.0 * (end.position - start.position) / h - velocity_[0] - velocity_[1] -
                 velocity_[3] - velocity_[4];
  acceleration_ = {start.acceleration, 4.0 * (velocity_[2] - velocity_[1]) / h,
                   4.0 * (velocity_[3] - velocity_[2]) / h, end.acceleration};
  position_[0] = start.position;
  for (std::size_t i = 0; i < 2; ++i) position_[i + 1] = position_[i] + 0.2 * h * velocity_[i];
  position_[5] = end.position;
  for (std::size_t i = 5; i > 3; --i) position_[i - 1] = position_[i] - 0.2 * h * velocity_[i - 1];
}

Extreme QuinticStep::speed() const {
  const bool at_ends =
      largest(velocity_) <= std::max(std::abs(velocity_.front()), std::abs(velocity_.back()));
  return largest_at(velocity_, rounding_, at_ends ? Roots{} : acceleration_roots());
}

Extreme QuinticStep::acceleration() const {
  const bool at_ends = largest(acceleration_) <=
                       std::max(std::abs(acceleration_.front()), std::abs(acceleration_.back()));
  return largest_at(acceleration_, kAccelerationRounding * rounding_ / duration_,
                    at_ends ? Roots{} : jerk_roots());
}

Extreme QuinticStep::position_extreme(double side) const {
  Extreme result{position_.front(), 0.0};
  if (side * position_.back() > side * result.value) result = {position_.back(), 1.0};
  const Roots inner = velocity_roots();
  for (std::size_t i = 0; i < inner.count; ++i) {
    const double value = bernstein(position_, inner.at[i]);
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

// Where a polynomial changes sign that rises or falls throughout between its derivative's roots.
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
  return between(acceleration_, jerk_roots());
}

QuinticStep::Roots QuinticStep::velocity_roots() const {
  const auto [least, most] = std::minmax_element(velocity_.begin(), velocity_.end());
  if (*least >= 0.0 || *most <= 0.0) return {};
  return between(velocity_, acceleration_roots());
}

MotionExtremes motion_extremes(const Eigen::Ref<const Eigen::VectorXd>& times,
                               const Eigen::Ref<const Rows>& positions,
                               const Eigen::Ref<const Rows>& velocities,
                               const Eigen::Ref<const Rows>& accelerations) {
  const Index steps = times.size() - 1, joints = positions.cols();
  MotionExtremes result;
  for (Rows* rows : {&result.lowest, &result.highest, &result.speed, &result.acceleration,
                     &result.time_of_lowest, &result.time_of_highest, &result.time_of_speed,
                     &result.time_of_acceleration})
    rows->resize(steps, joints);
  for (Index k = 0; k < steps; ++k) {
    const double duration = times[k + 1] - times[k];
    for (Index j = 0; j < joints; ++j) {
      const auto state = [&](Index row) -> JointState {
        return {positions(row, j), velocities(row, j), accelerations(row, j)};
      };
      const QuinticStep step(duration, state(k), state(k + 1));
      const auto note = [&](const Extreme& extreme, Rows& value, Rows& time) {
        value(k, j) = extreme.value;
        time(k, j) = extreme.at < 1.0 ? times[k] + extreme.at * duration : times[k + 1];
      };
      note(step.lowest(), result.lowest, result.time_of_lowest);
      note(step.highest(), result.highest, result.time_of_highest);
      note(step.speed(), result.speed, result.time_of_speed);
      note(step.acceleration(), result.acceleration, result.time_of_acceleration);
    }
  }
  return result;
}

}  // namespace leadthrough
