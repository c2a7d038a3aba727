#pragma once

// Kernels shared by solve_ik and track: a damped least-squares step inside a box. M is the task's
// dimension. Nothing here allocates.

#include "leadthrough/ik/task.hpp"

namespace leadthrough {

// Damping in units of the squared error.
constexpr double kErrorDamping = 0.05;
// Keeps the damped matrix regular at singularities: (1 mm)^2, a relative bias of 1e-6 for a joint
// that moves the tip by 1 m per rad.
constexpr double kDampingFloor = 1e-6;

// Step of every joint that has a preferred value, by a share of the distance to it.
inline JointArray pull_to(const JointArray& preferred, int joints, const JointArray& q,
                          double share) {
  JointArray pull{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(joints); ++i)
    if (std::isfinite(preferred[i])) pull[i] = share * (preferred[i] - q[i]);
  return pull;
}

// The factors L D L^T of J J^T + damping over the free columns: without square roots, whose latency
// would dominate. False unless all pivots exceed `smallest` times the largest diagonal
// element.
template <int M>
class DampedNormal {
 public:
  template <typename IsFree>
  DampedNormal(const Task<M>& task, int joints, double damping, IsFree is_free) {
    // Local sums, so that they can stay in registers.
    double sum[M][M] = {};
    for (int row = 0; row < M; ++row) sum[row][row] = damping;
    for (int i = 0; i < joints; ++i) {
      if (!is_free(i)) continue;
      const TaskVector<M>& column = task.columns[static_cast<std::size_t>(i)];
      for (int row = 0; row < M; ++row)
        for (int col = 0; col <= row; ++col) sum[row][col] += column[row] * column[col];
    }
    for (int row = 0; row < M; ++row)
      for (int col = 0; col <= row; ++col) factor_[row][col] = sum[row][col];
    // A row of zeros makes no matrix singular.
#pragma GCC unroll 8
    for (int row = 1; row < M; ++row)
      if (row >= task.rows) factor_[row][row] = factor_[0][0];
  }

  bool factorize(double smallest) {
    double largest = 0.0;
    for (int i = 0; i < M; ++i) largest = std::max(largest, factor_[i][i]);
    for (int col = 0; col < M; ++col) {
      const double pivot = factor_[col][col];
      if (!(pivot > smallest * largest)) return false;
      inverse_[col] = 1.0 / pivot;
      double scaled[M];
      for (int row = col + 1; row < M; ++row) scaled[row] = factor_[row][col] * inverse_[col];
      for (int row = col + 1; row < M; ++row)
        for (int k = col + 1; k <= row; ++k) factor_[row][k] -= scaled[row] * factor_[k][col];
      for (int row = col + 1; row < M; ++row) factor_[row][col] = scaled[row];
    }
    return true;
  }

  TaskVector<M> solve(const TaskVector<M>& right) const {
    TaskVector<M> x = right;
    for (int col = 0; col < M; ++col)
      for (int row = col + 1; row < M; ++row) x[row] -= factor_[row][col] * x[col];
    for (int row = 0; row < M; ++row) x[row] *= inverse_[row];
    for (int row = M - 1; row > 0; --row)
      for (int k = 0; k < row; ++k) x[k] -= factor_[row][k] * x[row];
    return x;
  }

 private:
  double factor_[M][M];
  double inverse_[M];
};

// The step d inside lower <= d <= upper with the least |J d - e|^2 + damping |d - rest|^2, by an
// active set: joints that leave the box are held at its side until their multiplier changes sign.
template <int M>
class BoxedStep {
 public:
  BoxedStep(const Task<M>& task, int joints, double damping, const JointArray& rest,
            const JointBox& box)
      : task_(task),
        joints_(joints),
        damping_(damping),
        rest_(rest),
        lower_(box.lower),
        upper_(box.upper) {}

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

  // The best step of the free joints, the others held; false if rounding left no solution.
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
                      const JointBox& box) {
  return BoxedStep<M>(task, joints, damping, rest, box).solve();
}

}  // namespace leadthrough
