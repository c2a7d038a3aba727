#pragma once

// The fastest way of an axis to rest at a target inside limits of velocity, acceleration and jerk,
// followed one period at a time from any state. Limits need not be symmetric; low < 0 < high.

#include "leadthrough/time/quintic_step.hpp"

namespace leadthrough {

struct AxisLimits {
  double velocity_low, velocity_high, acceleration_low, acceleration_high, jerk_low, jerk_high;
};

// Of many axes: states (position, velocity, acceleration) and limits, in the order of AxisLimits,
// in the columns of tables (3, axes) and (6, axes).

// Positions of axes after they have stopped as fast as they may.
Eigen::VectorXd resting_places(const RowsRef& states, const RowsRef& limits);
// Times until each rests at its target.
Eigen::VectorXd times_to_rest(const RowsRef& states, const RowsRef& limits,
                              const VectorRef& targets);
// The states one period on.
Rows step_each(const RowsRef& states, const RowsRef& limits, const VectorRef& targets,
               double period);
// The same, but the faster ones keep so low a speed on the way that all rest at the same time.
Rows step_together(const RowsRef& states, const RowsRef& limits, const VectorRef& targets,
                   double period);

// The state of one axis a period on.
JointState step_axis(const JointState& state, double target, const AxisLimits& limits,
                     double period);

}  // namespace leadthrough
