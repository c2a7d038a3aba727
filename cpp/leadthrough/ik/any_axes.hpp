#pragma once

// Descents and errors for callers independent of the number of constrained axes. The templates
// behind them, instantiated for each number of axes, are compiled in this folder only.

#include <optional>

#include "leadthrough/ik/pose_descent.hpp"

namespace leadthrough {

// Error of the tip at a configuration, and its derivative by each joint; free axes have no rows.
// Rotations are weighted as in inverse kinematics.
struct TipError {
  int rows = 0;
  Vector6 error;
  std::array<Vector6, kMaxJoints> columns;
};

void evaluate(const Chain& chain, const IkTarget& target, const std::optional<IkAxes>& axes,
              const JointArray& q, TipError& error);

// Moves q onto the target inside the bounds; false if it cannot be met to the tolerance.
bool settle(const Chain& chain, const IkTarget& target, const std::optional<IkAxes>& axes,
            const JointBox& bounds, const IkTolerance& tolerance, int max_iterations,
            JointArray& q);

}  // namespace leadthrough
