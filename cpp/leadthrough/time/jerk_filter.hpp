#pragma once

// The fastest way of an axis to rest at a target inside limits of velocity, acceleration and jerk,
// followed one period at a time from any state. Limits need not be symmetric; low < 0 < high.

#include <Eigen/Core>

namespace leadthrough {

struct AxisLimits {
  double velocity_low, velocity_high, acceleration_low, acceleration_high, jerk_low, jerk_high;
};

struct AxisState {
  double position, velocity, acceleration;
};

// Many axes: states (position, velocity, acceleration) and limits, in the order of AxisLimits, in
// the columns of tables.
using AxisColumns = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct AxisBatch {
  Eigen::Ref<const AxisColumns> states;  // (3, axes)
  Eigen::Ref<const AxisColumns> limits;  // (6, axes)

  Eigen::Index size() const { return states.cols(); }
  AxisState state(Eigen::Index i) const { return {states(0, i), states(1, i), states(2, i)}; }
  AxisLimits limit(Eigen::Index i) const {
    return {limits(0, i), limits(1, i), limits(2, i), limits(3, i), limits(4, i), limits(5, i)};
  }
};

using AxisTargets = Eigen::Ref<const Eigen::VectorXd>;

// Positions of axes after they have stopped as fast as they may.
Eigen::VectorXd resting_places(const AxisBatch& axes);
// Times until each rests at its target.
Eigen::VectorXd times_to_rest(const AxisBatch& axes, const AxisTargets& targets);
// The state of one axis a period on.
AxisState step_axis(const AxisState& state, double target, const AxisLimits& limits, double period);
// The states one period on.
AxisColumns step_each(const AxisBatch& axes, const AxisTargets& targets, double period);
// The same, but the faster ones keep so low a speed on the way that all rest at the same time.
AxisColumns step_together(const AxisBatch& axes, const AxisTargets& targets, double period);

}  // namespace leadthrough
