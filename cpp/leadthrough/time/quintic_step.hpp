#pragma once

// One joint between two samples: the quintic Hermite curve through the positions, velocities and
// accelerations of both, as ROS 2's joint trajectory controller interpolates.

#include <algorithm>
#include <array>
#include <cmath>

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

struct JointState {
  double position, velocity, acceleration;
};

// A value, and the fraction of the step at which it is reached.
struct Extreme {
  double value, at;
};

class QuinticStep {
 public:
  // The step takes `duration` > 0.
  QuinticStep(double duration, const JointState& start, const JointState& end);

  Extreme lowest() const { return position_extreme(-1.0); }
  Extreme highest() const { return position_extreme(1.0); }
  // The largest magnitudes. Between the samples they count by as much as the rounding of the
  // positions cannot explain.
  Extreme speed() const;
  Extreme acceleration() const;
  // Cheap numbers that they do not exceed.
  double speed_bound() const { return largest(velocity_); }
  double acceleration_bound() const { return largest(acceleration_); }

 private:
  template <std::size_t size>
  static double largest(const std::array<double, size>& values) {
    double result = 0.0;
    for (const double value : values) result = std::max(result, std::abs(value));
    return result;
  }

  // Fractions inside the step, in rising order.
  struct Roots {
    std::array<double, 4> at{};
    std::size_t count = 0;
  };

  Extreme position_extreme(double side) const;
  Roots jerk_roots() const;
  Roots acceleration_roots() const;
  Roots velocity_roots() const;
  std::array<double, 6> position() const;
  // Of the difference of the positions over the duration.
  double rounding() const;

  double duration_, start_, end_;
  // Bernstein coefficients.
  std::array<double, 5> velocity_;
  std::array<double, 4> acceleration_;
};

// Inline, as the search for a time law makes one for each joint and sample.
inline QuinticStep::QuinticStep(double duration, const JointState& start, const JointState& end)
    : duration_(duration), start_(start.position), end_(end.position) {
  const double h = duration;
  velocity_ = {start.velocity, start.velocity + 0.25 * h * start.acceleration, 0.0,
               end.velocity - 0.25 * h * end.acceleration, end.velocity};
  velocity_[2] = 5.0 * (end.position - start.position) / h - velocity_[0] - velocity_[1] -
                 velocity_[3] - velocity_[4];
  acceleration_ = {start.acceleration, 4.0 * (velocity_[2] - velocity_[1]) / h,
                   4.0 * (velocity_[3] - velocity_[2]) / h, end.acceleration};
}

// Joints whose bounds are computed at once.
constexpr Eigen::Index kLanes = 8;
using Lanes = Eigen::Array<double, kLanes, 1>;

struct LaneStates {
  Lanes position = Lanes::Zero(), velocity = Lanes::Zero(), acceleration = Lanes::Zero();

  JointState joint(Eigen::Index lane) const {
    return {position[lane], velocity[lane], acceleration[lane]};
  }
};

// Bounds of the magnitudes between two samples and at the second.
struct LaneBounds {
  LaneBounds(double duration, const LaneStates& start, const LaneStates& end) {
    const Lanes v1 = start.velocity + (0.25 * duration) * start.acceleration;
    const Lanes v3 = end.velocity - (0.25 * duration) * end.acceleration;
    const Lanes v2 = (5.0 / duration) * (end.position - start.position) - start.velocity - v1 - v3 -
                     end.velocity;
    speed = v1.abs().max(v2.abs()).max(v3.abs()).max(end.velocity.abs());
    acceleration =
        ((4.0 / duration) * (v2 - v1).abs().max((v3 - v2).abs())).max(end.acceleration.abs());
  }

  Lanes speed, acceleration;
};

// The largest magnitudes of all joints (columns) in all steps (rows) of a motion of two samples or
// more.
struct StepExtremes {
  Rows speed, acceleration;
};
StepExtremes step_extremes(const VectorRef& times, const RowsRef& positions,
                           const RowsRef& velocities, const RowsRef& accelerations);

// The extremes of each joint (column) over a motion of two samples or more: by row the lowest and
// the highest position, and the largest magnitudes of speed, acceleration and jerk, the difference
// of the acceleration over a step. With the times and steps at which they are reached first.
struct MotionPeaks {
  Rows value, time, step;
};
MotionPeaks motion_peaks(const VectorRef& times, const RowsRef& positions,
                         const RowsRef& velocities, const RowsRef& accelerations);

}  // namespace leadthrough
