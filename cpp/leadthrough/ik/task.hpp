#pragma once

// A target relative to a configuration: the error and its derivative by each joint.
// M is the task's dimension: 6 for poses, 3 for positions. Nothing here allocates.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "leadthrough/ik/solve.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace leadthrough {

// Weight of rotations against translations: 0.3 m per rad is about the arm's reach from its wrist.
constexpr double kOrientationWeight = 0.3;

template <int M>
using TaskVector = Eigen::Matrix<double, M, 1>;
using JointArray = std::array<double, kMaxJoints>;

// Bounds of each joint.
struct JointBox {
  JointArray lower{}, upper{};
};

inline JointBox position_limits(const Chain& chain) {
  JointBox limits;
  std::copy(chain.lower.begin(), chain.lower.end(), limits.lower.begin());
  std::copy(chain.upper.begin(), chain.upper.end(), limits.upper.begin());
  return limits;
}

// The part of a box that lies no farther than `most` from q, joint by joint.
inline JointBox around(const JointArray& q, double most, const JointBox& box, int joints) {
  JointBox near;
  for (std::size_t i = 0; i < static_cast<std::size_t>(joints); ++i) {
    near.lower[i] = std::max(box.lower[i], q[i] - most);
    near.upper[i] = std::min(box.upper[i], q[i] + most);
  }
  return near;
}

// The changes of q that end in a box.
inline JointBox changes_into(const JointBox& box, const JointArray& q, int joints) {
  JointBox changes;
  for (std::size_t i = 0; i < static_cast<std::size_t>(joints); ++i) {
    changes.lower[i] = box.lower[i] - q[i];
    changes.upper[i] = box.upper[i] - q[i];
  }
  return changes;
}

// q after a step, inside a box.
inline JointArray moved_in(const JointBox& box, const JointArray& q, const JointArray& step,
                           int joints) {
  JointArray moved{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(joints); ++i)
    moved[i] = std::clamp(q[i] + step[i], box.lower[i], box.upper[i]);
  return moved;
}

// A target relative to a configuration, rotations weighted.
template <int M>
struct Task {
  TaskVector<M> error;
  std::array<TaskVector<M>, kMaxJoints> columns;
  double position_error = 0.0;
  double orientation_error = 0.0;
  int rows = M;         // the last ones, of free axes, are zero
  bool in_axes = true;  // each axis with a tolerance of its own is inside it

  double squared() const { return error.squaredNorm(); }
  bool within(const IkTolerance& tolerance) const {
    return in_axes && position_error <= tolerance.position &&
           orientation_error <= tolerance.orientation;
  }
};

// orientations: w, x, y, z; may have no rows.
inline IkTarget target_in_row(const Rows3Ref& positions, const Rows4Ref& orientations,
                              Eigen::Index row) {
  IkTarget target{positions.row(row), std::nullopt};
  if (orientations.rows() > 0)
    target.rotation = so3::to_matrix(Eigen::Vector4d(orientations.row(row)));
  return target;
}

inline Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& m) {
  const Eigen::Vector3d skew(0.5 * (m(2, 1) - m(1, 2)), 0.5 * (m(0, 2) - m(2, 0)),
                             0.5 * (m(1, 0) - m(0, 1)));
  const double sine = skew.norm();
  const double cosine = 0.5 * (m.trace() - 1.0);
  // Near pi the skew part does not determine the axis.
  constexpr double kLostAxis = 1e-3;
  if (cosine < 0.0 && sine < kLostAxis) return so3::log(so3::from_matrix(m));
  return sine == 0.0 ? skew : Eigen::Vector3d(skew * (std::atan2(sine, cosine) / sine));
}

// The first `joints` values of q, with the errors there.
template <int M>
IkResult result_at(const JointArray& q, int joints, const Task<M>& task, IkStatus status,
                   int iterations) {
  IkResult result;
  result.q = Eigen::Map<const Eigen::VectorXd>(q.data(), joints);
  result.status = status;
  result.position_error = task.position_error;
  result.orientation_error = task.orientation_error;
  result.iterations = iterations;
  return result;
}

template <int M>
void evaluate(const Chain& chain, const IkTarget& target, const double* q, Task<M>& task) {
  Kinematics kinematics;
  forward_kinematics(chain, q, kinematics);
  const auto n = static_cast<std::size_t>(chain.joints());
  const Eigen::Vector3d offset = target.position - kinematics.T_base_tip.position;
  task.error.template head<3>() = offset;
  task.position_error = offset.norm();
  for (std::size_t i = 0; i < n; ++i)
    task.columns[i].template head<3>() = kinematics.jacobian[i].template head<3>();
  if constexpr (M == 6) {
    const Eigen::Vector3d turn =
        rotation_vector(*target.rotation * kinematics.T_base_tip.rotation.transpose());
    task.orientation_error = turn.norm();
    task.error.template tail<3>() = kOrientationWeight * turn;
    for (std::size_t i = 0; i < n; ++i)
      task.columns[i].template tail<3>() =
          kOrientationWeight * kinematics.jacobian[i].template tail<3>();
  }
}

}  // namespace leadthrough
