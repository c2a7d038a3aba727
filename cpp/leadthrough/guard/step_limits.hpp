#pragma once

// A stream of commanded states, one row a period: positions, velocities and accelerations of all
// joints, (n, 3 joints). Between two rows runs the quintic through both; the limits are judged on
// it, as `lt.check_limits` does, and the jerk as the difference of the acceleration over a period.

#include <optional>

#include "leadthrough/base/matrix.hpp"
#include "leadthrough/time/quintic_step.hpp"

namespace leadthrough::guard {

// One value a joint, finite and above zero but for the positions; rad or m, and s.
struct StepLimits {
  Eigen::VectorXd lower, upper;
  Eigen::VectorXd velocity, acceleration, jerk;
  double period = 0.0;

  Eigen::Index joints() const { return velocity.size(); }
};

// These throw std::invalid_argument, as do the functions of this folder: limits of other sizes or
// not above zero; a start that is no finite state (1, 3 joints); fewer rows or others than states.
void check_limits(const StepLimits& limits);
void check_start(const StepLimits& limits, const RowsRef& start);
void check_states(const StepLimits& limits, const RowsRef& rows, Eigen::Index least);

inline JointState joint_state(const RowsRef& rows, Eigen::Index row, Eigen::Index joint) {
  const Eigen::Index joints = rows.cols() / 3;
  return {rows(row, joint), rows(row, joints + joint), rows(row, 2 * joints + joint)};
}

template <typename Row>
void put(const JointState& state, Eigen::Index joint, Row row) {
  const Eigen::Index joints = row.size() / 3;
  row[joint] = state.position;
  row[joints + joint] = state.velocity;
  row[2 * joints + joint] = state.acceleration;
}

// The first limit that is exceeded; order 0 is the position.
struct Excess {
  int order = 0;
  Eigen::Index sample = 0, joint = 0;
  double ratio = 0.0;
};

// In the steps from a state (1, 3 joints) to the first sample (n, 3 joints) and on.
std::optional<Excess> first_excess(const StepLimits& limits, const RowsRef& start,
                                   const RowsRef& samples);

// True if no limit is exceeded in the step that ends at row k >= 1 of a stream.
inline bool keeps(const StepLimits& limits, const RowsRef& stream, Eigen::Index k) {
  return !first_excess(limits, stream.middleRows(k - 1, 1), stream.middleRows(k, 1));
}

// Factor by which each sample but the first must be slowed down: the largest of the ratio to the
// limit of order 1, the square root of that of order 2 and the cube root of that of order 3; at
// most 1 where no limit is exceeded, and else perhaps too small, if above 1.
Eigen::VectorXd slowdowns(const StepLimits& limits, const RowsRef& samples);

}  // namespace leadthrough::guard
