#pragma once

// One joint between two samples: the quintic Hermite curve through the positions, velocities and
// accelerations of both, as ROS 2's joint trajectory controller interpolates.

#include <array>

#include "base/matrix.hpp"

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

 private:
  // Fractions inside the step, in rising order.
  struct Roots {
    std::array<double, 4> at{};
    std::size_t count = 0;
  };

  Extreme position_extreme(double side) const;
  Roots jerk_roots() const;
  Roots acceleration_roots() const;
  Roots velocity_roots() const;

  double rounding_;  // of the difference of the positions over the duration
  double duration_;
  // Bernstein coefficients.
  std::array<double, 6> position_;
  std::array<double, 5> velocity_;
  std::array<double, 4> acceleration_;
};

// Extremes of all joints (columns) in all steps (rows) of a motion of two samples or more, and the
// times at which they are reached.
struct MotionExtremes {
  Rows lowest, highest, speed, acceleration;
  Rows time_of_lowest, time_of_highest, time_of_speed, time_of_acceleration;
};
MotionExtremes motion_extremes(const Eigen::Ref<const Eigen::VectorXd>& times,
                               const Eigen::Ref<const Rows>& positions,
                               const Eigen::Ref<const Rows>& velocities,
                               const Eigen::Ref<const Rows>& accelerations);

}  // namespace leadthrough
