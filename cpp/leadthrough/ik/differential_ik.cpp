#include "leadthrough/ik/differential_ik.hpp"

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/ik/damped_step.hpp"

namespace leadthrough {

namespace {

// Of the null space's projector: it leaks at most half the root of this, in m a rad.
constexpr double kProjectorDamping = 1e-14;
// Fraction of the acceleration limit reserved for braking; the rest is for the changing Jacobian
// and for the null space.
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

    const TaskVector<M> error = task_.error;
    const double damping = kErrorDamping * error.squaredNorm() + kDampingFloor;
    task_.error = share_of_error(damping) * error + solver_.dt * weighted(twist);
    const JointBox calm = sides(nullptr), sudden = sides(qd_.data());
    const JointArray step =
        towards(boxed_step(task_, joints(), damping, self_motion(), calm), sudden);
    const JointArray total = straightened(step, error, sudden);

    answer.q.resize(joints());
    answer.qd.resize(joints());
    for (std::size_t i = 0; i < n_; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      answer.qd[k] = total[i] / solver_.dt;
      answer.q[k] = std::clamp(q_[i] + total[i], std::min(q_[i], solver_.limits.lower[k]),
                               std::max(q_[i], solver_.limits.upper[k]));
    }
    return answer;
  }

 private:
  // The bounds of a step.
  JointBox sides(const double* qd) const {
    const MotionBox box = velocity_box(solver_.limits, q_.data(), qd, solver_.dt);
    JointBox found;
    for (std::size_t i = 0; i < n_; ++i) {
      found.lower[i] = solver_.dt * box.lower[static_cast<Eigen::Index>(i)];
      found.upper[i] = solver_.dt * box.upper[static_cast<Eigen::Index>(i)];
    }
    return found;
  }

  // As near to `wanted` as the accelerations allow on the line from the last step: least squares
  // inside their narrow box would play the joints against each other and oscillate.
  JointArray towards(const JointArray& wanted, const JointBox& sudden) const {
    JointArray change{}, step{};
    for (std::size_t i = 0; i < n_; ++i) change[i] = wanted[i] - solver_.dt * qd_[i];
    const double part = proportion(change, 1.0);
    for (std::size_t i = 0; i < n_; ++i)
      step[i] =
          std::clamp(solver_.dt * qd_[i] + part * change[i], sudden.lower[i], sudden.upper[i]);
    return step;
  }

  // Fraction of the error for a step: every joint stays at a speed from which it can brake before
  // the target, and all slow down together, so that the tool stays on its course.
  double share_of_error(double damping) const {
    JointBox open;
    open.lower.fill(-kInfinity);
    open.upper.fill(kInfinity);
    const JointArray full = boxed_step(task_, joints(), damping, {}, open);
    double rate = std::min(solver_.gain, 1.0 / solver_.dt);
    for (std::size_t i = 0; i < n_; ++i) {
      const double distance = std::abs(full[i]);
      if (distance * rate > speed_for(distance, i)) rate = speed_for(distance, i) / distance;
    }
    return rate * solver_.dt;
  }

  double speed_for(double distance, std::size_t joint) const {
    const auto k = static_cast<Eigen::Index>(joint);
    const double a = kBrakingShare * solver_.limits.acceleration[k];
    return std::min(solver_.limits.velocity[k], braking_speed(distance, a, solver_.dt));
  }

  TaskVector<M> weighted(const Vector6& twist) const {
    TaskVector<M> whole = twist.head<M>();
    if constexpr (M == 6) whole.template tail<3>() *= kOrientationWeight;
    return whole;
  }

  // Towards the posture, in the null space of the task, with a small part of the accelerations; the
  // rest remains for the task.
  JointArray self_motion() const {
    JointArray last{};
    if (!(solver_.posture_gain > 0.0)) return last;
    DampedNormal<M> normal(task_, joints(), kProjectorDamping, [](int) { return true; });
    if (!normal.factorize(0.0)) return last;
    const double rate = std::min(solver_.posture_gain, 1.0 / solver_.dt);
    JointArray change{};
    for (std::size_t i = 0; i < n_; ++i) {
      const double distance = solver_.posture[static_cast<Eigen::Index>(i)] - q_[i];
      const double speed = std::min(rate * std::abs(distance), speed_for(std::abs(distance), i));
      last[i] = solver_.dt * qd_[i];
      change[i] = solver_.dt * std::copysign(speed, distance) - last[i];
    }
    free_of_task(normal, last);
    free_of_task(normal, change);
    const double part = proportion(change, kBrakingShare);
    for (std::size_t i = 0; i < n_; ++i) last[i] += part * change[i];
    return last;
  }

  void free_of_task(const DampedNormal<M>& normal, JointArray& motion) const {
    TaskVector<M> leak = TaskVector<M>::Zero();
    for (std::size_t i = 0; i < n_; ++i) leak += motion[i] * task_.columns[i];
    const TaskVector<M> dual = normal.solve(leak);
    for (std::size_t i = 0; i < n_; ++i) motion[i] -= task_.columns[i].dot(dual);
  }

  // A change of the step, scaled to that fraction of every acceleration limit.
  double proportion(const JointArray& change, double share) const {
    double part = 1.0;
    for (std::size_t i = 0; i < n_; ++i) {
      const double most = share * solver_.limits.acceleration[static_cast<Eigen::Index>(i)] *
                          solver_.dt * solver_.dt;
      if (part * std::abs(change[i]) > most) part = most / std::abs(change[i]);
    }
    return part;
  }

  // The step corrected for the curvature of the kinematics: it removes the difference between the
  // reached pose and the pose predicted by the Jacobian.
  JointArray straightened(const JointArray& step, const TaskVector<M>& error, const JointBox& box) {
    TaskVector<M> predicted_error = TaskVector<M>::Zero();
    JointArray moved = q_;
    for (std::size_t i = 0; i < n_; ++i) {
      moved[i] += step[i];
      predicted_error += step[i] * task_.columns[i];
    }
    IkTarget predicted = target_;
    predicted.position += predicted_error.template head<3>() - error.template head<3>();
    if constexpr (M == 6) {
      const Eigen::Vector3d rotation = predicted_error.template tail<3>() / kOrientationWeight;
      const Eigen::Vector3d back = error.template tail<3>() / -kOrientationWeight;
      predicted.rotation =
          so3::to_matrix(so3::compose(so3::exp(rotation), so3::exp(back))) * *target_.rotation;
    }
    evaluate(solver_.chain, predicted, moved.data(), task_);
    const JointBox left = changes_into(box, step, joints());
    return moved_in(box, step, boxed_step(task_, joints(), kDampingFloor, {}, left), joints());
  }

  int joints() const { return static_cast<int>(n_); }

  const DifferentialIk& solver_;
  const IkTarget& target_;
  std::size_t n_;
  JointArray q_{}, qd_{};
  Task<M> task_;
};

template <typename Vector>
bool is_usable(const Vector& values) {
  return (values.array().abs() <= kMaxStepInput).all();
}

}  // namespace

void check_sizes(const DifferentialIk& solver) {
  const int joints = solver.chain.joints();
  for (const JointVector* each : {&solver.limits.lower, &solver.limits.upper,
                                  &solver.limits.velocity, &solver.limits.acceleration})
    check_argument(each->size() == joints, "limits: one number a joint");
  check_argument(solver.posture.size() == joints, "posture: one number a joint");
}

DifferentialStep differential_step(const DifferentialIk& solver, const IkTarget& target,
                                   const Vector6& twist, const VectorRef& q, const VectorRef& qd) {
  const int joints = solver.chain.joints();
  check_argument(q.size() == joints && is_usable(q), "q: one finite number a joint");
  check_argument(qd.size() == joints && is_usable(qd), "qd: one finite number a joint");
  check_argument(is_usable(target.position) && is_usable(twist), "target, twist: finite numbers");
  if (target.rotation) return Stepper<6>(solver, target, q.data(), qd.data()).run(twist);
  return Stepper<3>(solver, target, q.data(), qd.data()).run(twist);
}

}  // namespace leadthrough
