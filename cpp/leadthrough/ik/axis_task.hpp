#pragma once

// Targets that constrain some axes only, or each axis with its own tolerance and weight. The axes
// are those of the target's frame. Constrained axes have the first rows of a task of six; the rest
// is zero, and Task::rows tells it apart.
//
// Rotations are measured by what is left between tip and target: the rotation vector where all
// three axes are constrained; with one free axis the swing, the shortest rotation of the tool's
// axis onto the target's, for any spin about it; with two free axes the twist about the third.

#include <type_traits>

#include "leadthrough/ik/task.hpp"

namespace leadthrough {

struct AxisTarget {
  AxisTarget(const IkTarget& target, const IkAxes& axes)
      : position(target.position), frame(target.rotation.value_or(Eigen::Matrix3d::Identity())) {
    for (int k = 0; k < (target.rotation ? 6 : 3); ++k) {
      if (axes.free[static_cast<std::size_t>(k)]) continue;
      const int row = rows();
      (k < 3 ? translations : rotations) += 1;
      axis[static_cast<std::size_t>(row)] = k % 3;
      scale[row] = axes.weight[k] * (k < 3 ? 1.0 : kOrientationWeight);
      tolerance[row] = axes.tolerance[k];
    }
    for (int k = 0; rotations == 2 && k < 3; ++k)
      if (axes.free[static_cast<std::size_t>(3 + k)]) lone_axis = k;
    if (rotations == 1) lone_axis = axis[static_cast<std::size_t>(rows() - 1)];
  }

  int rows() const { return translations + rotations; }

  Eigen::Vector3d position;
  Eigen::Matrix3d frame;  // its columns are the axes
  int translations = 0, rotations = 0;
  std::array<int, 6> axis{};  // of each row, 0 to 2
  TaskVector<6> scale;        // weights, rotations in m a rad
  TaskVector<6> tolerance;
  int lone_axis = 0;  // the free one of two rotations, the constrained one of a single rotation
};

// Rows of the task that are not zero, of M.
template <int M>
int constrained_rows(const IkTarget& /*target*/) {
  return M;
}
template <int M>
int constrained_rows(const AxisTarget& target) {
  return target.rows();
}

// Lower bound on the tip's distance from `point`, m, by the constrained axes, for any orientation.
inline double distance_from(const Eigen::Vector3d& point, const IkTarget& target) {
  return (target.position - point).norm();
}

inline double distance_from(const Eigen::Vector3d& point, const AxisTarget& target) {
  const Eigen::Vector3d away = target.frame.transpose() * (target.position - point);
  double squared = 0.0;
  for (int row = 0; row < target.translations; ++row) {
    const double along = std::abs(away[target.axis[static_cast<std::size_t>(row)]]);
    const double tolerated = std::isfinite(target.tolerance[row]) ? target.tolerance[row] : 0.0;
    squared += std::pow(std::max(along - tolerated, 0.0), 2);
  }
  return std::sqrt(squared);
}

// Orientation error in the target's frame, and its rate: an angular velocity w of the tip, in the
// same frame, changes `error` by -rate w. Rows of free axes are unused.
struct RotationError {
  Eigen::Vector3d error = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rate = Eigen::Matrix3d::Zero();
};

// rotation: the tip's rotation seen from the target, in these three.
inline RotationError rotation_vector_error(const Eigen::Matrix3d& rotation) {
  const Eigen::Vector3d v = rotation_vector(rotation.transpose());
  const double angle = v.norm();
  // Coefficient of the squared term; below a millirad its series is exact.
  const double second = angle < 1e-3
                            ? 1.0 / 12.0 + angle * angle / 720.0
                            : (1.0 - 0.5 * angle / std::tan(0.5 * angle)) / (angle * angle);
  const Eigen::Matrix3d cross = so3::skew(v);
  return {v, Eigen::Matrix3d::Identity() + 0.5 * cross + second * cross * cross};
}

// The shortest rotation of the tool's axis k onto the target's.
inline RotationError swing(const Eigen::Matrix3d& rotation, int k) {
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  const double x = rotation(i, k), y = rotation(j, k), cosine = rotation(k, k);
  const double sine = std::hypot(x, y);
  const double angle = std::atan2(sine, cosine);
  RotationError result;
  // For opposite axes every direction is equally short, and the rate is unbounded.
  constexpr double kNoDirection = 1e-12;
  constexpr double kSteepest = -10.0;
  const bool straight = sine < kNoDirection;
  const double dx = straight ? 1.0 : x / sine, dy = straight ? 0.0 : y / sine;
  const double across =
      straight ? (cosine > 0.0 ? 1.0 : kSteepest) : std::max(angle * cosine / sine, kSteepest);
  result.error[i] = angle * dy;
  result.error[j] = -angle * dx;
  result.rate(i, i) = dy * dy + across * dx * dx;
  result.rate(j, j) = dx * dx + across * dy * dy;
  result.rate(i, j) = result.rate(j, i) = (across - 1.0) * dx * dy;
  result.rate(i, k) = -angle * dx;
  result.rate(j, k) = -angle * dy;
  return result;
}

// The angle about axis k in "rotation = swing twist", Dobrowolski 2015.
inline RotationError twist(const Eigen::Matrix3d& rotation, int k) {
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  const so3::Quaternion q = so3::from_matrix(rotation);
  const double w = q[0], vi = q[1 + i], vj = q[1 + j], vk = q[1 + k];
  // At a swing of half a turn the twist is undefined.
  constexpr double kUndefined = 1e-6;
  const double squared = std::max(w * w + vk * vk, kUndefined);
  RotationError result;
  result.error[k] = w < 0.0 ? -2.0 * std::atan2(-vk, -w) : -2.0 * std::atan2(vk, w);
  result.rate(k, i) = (w * vj + vk * vi) / squared;
  result.rate(k, j) = (vk * vj - w * vi) / squared;
  result.rate(k, k) = 1.0;
  return result;
}

inline void evaluate(const Chain& chain, const AxisTarget& target, const double* q, Task<6>& task) {
  Kinematics kinematics;
  forward_kinematics(chain, q, kinematics);
  const Eigen::Vector3d offset =
      target.frame.transpose() * (target.position - kinematics.T_base_tip.position);
  RotationError result;
  if (target.rotations > 0) {
    const Eigen::Matrix3d rotation = target.frame.transpose() * kinematics.T_base_tip.rotation;
    result = target.rotations == 3   ? rotation_vector_error(rotation)
             : target.rotations == 2 ? swing(rotation, target.lone_axis)
                                     : twist(rotation, target.lone_axis);
  }
  const Eigen::Matrix3d rate = result.rate * target.frame.transpose();
  double position = 0.0, orientation = 0.0;
  task.in_axes = true;
  task.rows = target.rows();
  task.error.setZero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(chain.joints()); ++i)
    task.columns[i].setZero();
  for (int row = 0; row < task.rows; ++row) {
    const int k = target.axis[static_cast<std::size_t>(row)];
    const bool translation = row < target.translations;
    const double error = translation ? offset[k] : result.error[k];
    (translation ? position : orientation) += error * error;
    task.in_axes = task.in_axes && std::abs(error) <= target.tolerance[row];
    task.error[row] = target.scale[row] * error;
    for (std::size_t i = 0; i < static_cast<std::size_t>(chain.joints()); ++i) {
      const Vector6& column = kinematics.jacobian[i];
      const double speed = translation ? target.frame.col(k).dot(column.head<3>())
                                       : rate.row(k).dot(column.tail<3>());
      task.columns[i][row] = target.scale[row] * speed;
    }
  }
  task.position_error = std::sqrt(position);
  task.orientation_error = std::sqrt(orientation);
}

template <int M>
using Dimension = std::integral_constant<int, M>;

// Calls visit(Dimension<M>, target) with the target in the form for its axes; at least one must be
// constrained.
template <typename Visit>
auto visit_target(const IkTarget& target, const std::optional<IkAxes>& axes, Visit visit) {
  if (axes) return visit(Dimension<6>(), AxisTarget(target, *axes));
  return target.rotation ? visit(Dimension<6>(), target) : visit(Dimension<3>(), target);
}

}  // namespace leadthrough
