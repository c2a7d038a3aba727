#pragma once

// Descents and errors for callers that need not know how many axes are asked for. What they are
// made of, a copy for each number of axes, is compiled in this folder only.

#include <optional>

#include "ik/pose_descent.hpp"

namespace leadthrough {

// The error of the tip as seen from a configuration, and how each joint changes it: rows of axes
// left free are not there. Rotations are weighted as in inverse kinematics.
struct TipError {
  int rows = 0;
  Vector6 error;
  std::array<Vector6, kMaxJoints> columns;
};

void evaluate(const Chain& chain, const IkTarget& target, const std::optional<IkAxes>& axes,
              const JointArray& q, TipError& error);

// Moves q onto the target inside the bounds; false where it cannot be met to the tolerance.
bool settle(const Chain& chain, const IkTarget& target, const std::optional<IkAxes>& axes,
            const DescentBounds& bounds, const IkTolerance& tolerance, int max_iterations,
            JointArray& q);

}  // namespace leadthrough
