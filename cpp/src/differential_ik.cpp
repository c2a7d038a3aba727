#include "leadthrough/differential_ik.hpp"

#include <limits>

#include "damped_step.hpp"

namespace leadthrough {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// (1 mm)^2: for a joint that moves the tip 1 m a rad a bias of a millionth of the step.
constexpr double kDampingFloor = 1e-6;
// Of the null space's projector: it leaks at most half the root of this, in m a rad.
constexpr double kProjectorDamping = 1e-14;
// Of the acceleration limit, the share that a step counts on to brake; the rest is for the
// changing Jacobian and for the null space.
constexpr double kBrakingShare = 0.5;

template <int M>
class Stepper {
 public:
  Stepper(const DifferentialIk& solver, const IkTarget& target, const double* q, const double* qd)
      : solver_(solver), target_(target), n_(static_cast<std::size_t>(solver.chain.joints())) {
    std::copy(q, q + n_, q_.begin());
    std::copy(qd, qd + n_, qd_.begin());
  }

  DifferentialStep run(const Vector6& twist) {
    evaluate(solver_.chain, target_, q_.data(), task_);
    DifferentialStep answer;
    answer.position_error = task_.position_error;
    answer.orientation_error = task_.orientation_error;

    const MotionBox box = velocity_box(solver_.limits, q_.data(), qd_.data(), solver_.dt);
    JointArray lower{}, upper{};
    for (std::size_t i = 0; i < n_; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      lower[i] = solver_.dt * box.lower[k];
      upper[i] = solver_.dt * box.upper[k];
    }
    const TaskVector<M> error = task_.error;
    const double damping = kErrorDamping * error.squaredNorm() + kDampingFloor;
    task_.error = share(damping) * error + solver_.dt * weighted(twist);
    const JointArray step = boxed_step(task_, joints(), damping, self_motion(), lower, upper);
    const JointArray total = straightened(step, error, lower, upper);

    answer.q.resize(joints());
    answer.qd.resize(joints());
    for (std::size_t i = 0; i < n_; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      answer.qd[k] = std::clamp(total[i] / solver_.dt, box.lower[k], box.upper[k]);
      answer.q[k] = std::clamp(q_[i] + total[i], std::min(q_[i], solver_.limits.lower[k]),
                               std::max(q_[i], solver_.limits.upper[k]));
    }
    return answer;
  }

 private:
  // Of the error, what a step takes: every joint keeps a speed it can brake from within the way to
  // the target, and all slow down together, so that the tool keeps its course.
  double share(double damping) const {
    JointArray free{};
    free.fill(kInfinity);
    JointArray minus_free = free;
    for (double& side : minus_free) side = -side;
    const JointArray full = boxed_step(task_, joints(), damping, {}, minus_free, free);
    double rate = std::min(solver_.gain, 1.0 / solver_.dt);
    for (std::size_t i = 0; i < n_; ++i) {
      const double way = std::abs(full[i]);
      if (way * rate > speed_for(way, i)) rate = speed_for(way, i) / way;
    }
    return rate * solver_.dt;
  }

  double speed_for(double way, std::size_t joint) const {
    const auto k = static_cast<Eigen::Index>(joint);
    const double a = kBrakingShare * solver_.limits.acceleration[k];
    return std::min(solver_.limits.velocity[k], braking_speed(way, a, solver_.dt));
  }

  TaskVector<M> weighted(const Vector6& twist) const {
    TaskVector<M> whole = twist.head<M>();
    if constexpr (M == 6) whole.template tail<3>() *= kOrientationWeight;
    return whole;
  }

  // Towards the posture, in the null space of the task.
  JointArray self_motion() const {
    JointArray pull{};
    if (!(solver_.posture_gain > 0.0)) return pull;
    const double rate = std::min(solver_.posture_gain, 1.0 / solver_.dt);
    TaskVector<M> leak = TaskVector<M>::Zero();
    for (std::size_t i = 0; i < n_; ++i) {
      const double way = solver_.posture[static_cast<Eigen::Index>(i)] - q_[i];
      const double speed = std::min(rate * std::abs(way), speed_for(std::abs(way), i));
      pull[i] = solver_.dt * std::copysign(speed, way);
      leak += pull[i] * task_.columns[i];
    }
    DampedNormal<M> normal(task_, joints(), kProjectorDamping, [](int) { return true; });
    if (!normal.factorize(0.0)) return {};
    const TaskVector<M> dual = normal.solve(leak);
    for (std::size_t i = 0; i < n_; ++i) pull[i] -= task_.columns[i].dot(dual);
    return pull;
  }

  // The step without what the curvature of the kinematics makes of it.
  JointArray straightened(const JointArray& step, const TaskVector<M>& error,
                          const JointArray& lower, const JointArray& upper) {
    JointArray moved = q_, low{}, high{};
    TaskVector<M> expected = error;
    for (std::size_t i = 0; i < n_; ++i) {
      moved[i] += step[i];
      expected -= step[i] * task_.columns[i];
      low[i] = lower[i] - step[i];
      high[i] = upper[i] - step[i];
    }
    evaluate(solver_.chain, target_, moved.data(), task_);
    task_.error -= expected;
    JointArray total = boxed_step(task_, joints(), kDampingFloor, {}, low, high);
    for (std::size_t i = 0; i < n_; ++i) total[i] += step[i];
    return total;
  }

  int joints() const { return static_cast<int>(n_); }

  const DifferentialIk& solver_;
  const IkTarget& target_;
  std::size_t n_;
  JointArray q_{}, qd_{};
  Task<M> task_;
};

}  // namespace

DifferentialStep differential_step(const DifferentialIk& solver, const IkTarget& target,
                                   const Vector6& twist, const double* q, const double* qd) {
  if (target.rotation) return Stepper<6>(solver, target, q, qd).run(twist);
  return Stepper<3>(solver, target, q, qd).run(twist);
}

}  // namespace leadthrough
