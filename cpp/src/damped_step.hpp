#pragma once

// The kernels that solve_ik and track share. M is the task's dimension: 6 for poses, 3 for
// positions. Nothing here allocates.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "leadthrough/ik.hpp"
#include "leadthrough/so3.hpp"

namespace leadthrough {

// Weighs rotations against translations: 0.3 m a rad is about the arm's reach from its wrist.
constexpr double kOrientationWeight = 0.3;
// Damping in units of the squared error.
constexpr double kErrorDamping = 0.05;

template <int M>
using TaskVector = Eigen::Matrix<double, M, 1>;
using JointArray = std::array<double, kMaxJoints>;

// A target seen from a configuration, rotations weighted.
template <int M>
struct Task {
  TaskVector<M> error;
  std::array<TaskVector<M>, kMaxJoints> columns;
  double position_error = 0.0;
  double orientation_error = 0.0;

  double squared() const { return error.squaredNorm(); }
  bool within(const IkTolerance& tolerance) const {
    return position_error <= tolerance.position && orientation_error <= tolerance.orientation;
  }
};

// The step that takes every joint a share of its way to the middle of its range.
inline JointArray pull_to_middle(const Chain& chain, const JointArray& q, double share) {
  JointArray pull{};
  for (int i = 0; i < chain.joints(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double middle = 0.5 * chain.lower[i] + 0.5 * chain.upper[i];
    if (std::isfinite(middle)) pull[k] = share * (middle - q[k]);
  }
  return pull;
}

inline Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& m) {
  const Eigen::Vector3d skew(0.5 * (m(2, 1) - m(1, 2)), 0.5 * (m(0, 2) - m(2, 0)),
                             0.5 * (m(1, 0) - m(0, 1)));
  const double sine = skew.norm();
  const double cosine = 0.5 * (m.trace() - 1.0);
  // Near a half turn the axis is lost in the skew part.
  constexpr double kLostAxis = 1e-3;
  if (cosine < 0.0 && sine < kLostAxis) return so3::log(so3::from_matrix(m));
  return sine == 0.0 ? skew : Eigen::Vector3d(skew * (std::atan2(sine, cosine) / sine));
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

// The Cholesky factor of J J^T + damping over the free columns. False where it is not positive
// definite beyond `smallest` of its largest diagonal element.
template <int M>
class DampedNormal {
 public:
  template <typename IsFree>
  DampedNormal(const Task<M>& task, int joints, double damping, IsFree is_free) {
    for (int row = 0; row < M; ++row)
      for (int col = 0; col <= row; ++col) factor_[row][col] = row == col ? damping : 0.0;
    for (int i = 0; i < joints; ++i) {
      if (!is_free(i)) continue;
      const TaskVector<M>& column = task.columns[static_cast<std::size_t>(i)];
      for (int row = 0; row < M; ++row)
        for (int col = 0; col <= row; ++col) factor_[row][col] += column[row] * column[col];
    }
  }

  bool factorize(double smallest) {
    double largest = 0.0;
    for (int i = 0; i < M; ++i) largest = std::max(largest, factor_[i][i]);
    for (int col = 0; col < M; ++col) {
      double pivot = factor_[col][col];
      for (int k = 0; k < col; ++k) pivot -= factor_[col][k] * factor_[col][k];
      if (!(pivot > smallest * largest)) return false;
      inverse_[col] = 1.0 / std::sqrt(pivot);
      for (int row = col + 1; row < M; ++row) {
        double sum = factor_[row][col];
        for (int k = 0; k < col; ++k) sum -= factor_[row][k] * factor_[col][k];
        factor_[row][col] = sum * inverse_[col];
      }
    }
    return true;
  }

  TaskVector<M> solve(const TaskVector<M>& right) const {
    TaskVector<M> x;
    for (int row = 0; row < M; ++row) {
      double sum = right[row];
      for (int k = 0; k < row; ++k) sum -= factor_[row][k] * x[k];
      x[row] = sum * inverse_[row];
    }
    for (int row = M - 1; row >= 0; --row) {
      double sum = x[row];
      for (int k = row + 1; k < M; ++k) sum -= factor_[k][row] * x[k];
      x[row] = sum * inverse_[row];
    }
    return x;
  }

 private:
  double factor_[M][M];
  double inverse_[M];
};

// The step d inside lower <= d <= upper with the least |J d - e|^2 + damping |d - rest|^2, by an
// active set: joints that leave the box are held at its side, and released where that is wrong.
template <int M>
class BoxedStep {
 public:
  BoxedStep(const Task<M>& task, int joints, double damping, const JointArray& rest,
            const JointArray& lower, const JointArray& upper)
      : task_(task),
        joints_(joints),
        damping_(damping),
        rest_(rest),
        lower_(lower),
        upper_(upper) {}

  JointArray solve() {
    const int passes = 3 * joints_;  // an active set may cycle on ties
    for (int pass = 0; pass < passes; ++pass) {
      if (!solve_free()) break;
      if (hold_strays()) continue;
      if (!release_worst()) break;
    }
    for (std::size_t i = 0; i < count(); ++i) step_[i] = std::clamp(step_[i], lower_[i], upper_[i]);
    return step_;
  }

 private:
  enum class Side : signed char { kFree, kLower, kUpper };

  // The best step of the free joints, the others held; false where rounding left no solution.
  bool solve_free() {
    TaskVector<M> residual = task_.error;
    for (std::size_t i = 0; i < count(); ++i) {
      const double held = side_[i] == Side::kLower ? lower_[i] : upper_[i];
      step_[i] = side_[i] == Side::kFree ? rest_[i] : held;
      residual -= step_[i] * task_.columns[i];
    }
    DampedNormal<M> normal(task_, joints_, damping_, [this](int i) {
      return side_[static_cast<std::size_t>(i)] == Side::kFree;
    });
    if (!normal.factorize(0.0)) return false;
    dual_ = normal.solve(residual);
    for (std::size_t i = 0; i < count(); ++i)
      if (side_[i] == Side::kFree) step_[i] += task_.columns[i].dot(dual_);
    return true;
  }

  bool hold_strays() {
    bool any = false;
    for (std::size_t i = 0; i < count(); ++i) {
      if (side_[i] != Side::kFree || (step_[i] >= lower_[i] && step_[i] <= upper_[i])) continue;
      side_[i] = step_[i] < lower_[i] ? Side::kLower : Side::kUpper;
      any = true;
    }
    return any;
  }

  // At the solution e - J d is damping times dual, so a multiplier is damping times this pull.
  bool release_worst() {
    std::size_t worst = count();
    double most = 0.0;
    for (std::size_t i = 0; i < count(); ++i) {
      if (side_[i] == Side::kFree || lower_[i] == upper_[i]) continue;
      const double pull = task_.columns[i].dot(dual_) - (step_[i] - rest_[i]);
      const double inward = side_[i] == Side::kLower ? pull : -pull;
      if (inward <= most) continue;
      most = inward;
      worst = i;
    }
    if (worst == count()) return false;
    side_[worst] = Side::kFree;
    return true;
  }

  std::size_t count() const { return static_cast<std::size_t>(joints_); }

  const Task<M>& task_;
  int joints_;
  double damping_;
  const JointArray& rest_;
  const JointArray& lower_;
  const JointArray& upper_;
  std::array<Side, kMaxJoints> side_{};
  JointArray step_{};
  TaskVector<M> dual_;
};

template <int M>
JointArray boxed_step(const Task<M>& task, int joints, double damping, const JointArray& rest,
                      const JointArray& lower, const JointArray& upper) {
  return BoxedStep<M>(task, joints, damping, rest, lower, upper).solve();
}

}  // namespace leadthrough
