#pragma once

// Self-motion of redundant arms: towards a posture at a constant tool pose.

#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/ik/pose_descent.hpp"

namespace leadthrough {

// Goal of self-motion; joints without a goal follow the task.
struct SelfMotionGoal {
  JointArray q{};
  std::array<bool, kMaxJoints> pulled{};
};

inline SelfMotionGoal towards(const JointVector& posture) {
  SelfMotionGoal goal;
  for (Eigen::Index i = 0; i < posture.size(); ++i) {
    goal.q[static_cast<std::size_t>(i)] = posture[i];
    goal.pulled[static_cast<std::size_t>(i)] = true;
  }
  return goal;
}

// The middle of the ranges; joints without a range have no goal.
inline SelfMotionGoal towards_middle(const Chain& chain) {
  SelfMotionGoal goal = towards(middle(chain));
  for (int i = 0; i < chain.joints(); ++i)
    goal.pulled[static_cast<std::size_t>(i)] = std::isfinite(chain.lower[i] + chain.upper[i]);
  return goal;
}

template <int M, typename Target>
class SelfMotion {
 public:
  // `q` must lie inside the bounds. All arguments must outlive the motion.
  SelfMotion(const Chain& chain, const Target& target, const JointBox& bounds,
             const IkTolerance& tolerance, const JointArray& q)
      : chain_(chain),
        target_(target),
        bounds_(bounds),
        tolerance_{std::min(tolerance.position, kHold), std::min(tolerance.orientation, kHold)},
        q_(q) {
    evaluate(chain_, target_, q_.data(), task_);
  }

  // Steps in the exact null space, I - J^+ J of the undamped J over the joints that no limit
  // holds, each projected back onto the target and accepted if it brought the joints nearer to the
  // goal. `share` of the distance is tried first.
  void run(const SelfMotionGoal& goal, double share, int max_iterations) {
    constexpr int kSteps = 40;
    constexpr double kMinGain = 1e-5;          // of the distance, in a full step
    constexpr double kWellConditioned = 1e-9;  // pivots of J J^T: next to a singularity stay
    if (!hold(q_, kHoldSteps)) return;
    const double first = share;
    double distance = distance_to(goal, q_);
    for (int k = 0; k < kSteps && iterations_ < max_iterations; ++k) {
      check_interrupt();
      DampedNormal<M> normal(task_, joints(), 0.0, [](int) { return true; });
      if (!normal.factorize(kWellConditioned)) return;
      const Task<M> before = task_;
      JointArray trial = moved(goal, share);
      ++iterations_;
      const bool held = hold(trial, kBackSteps);
      const double nearer = distance_to(goal, trial);
      if (!held || nearer >= distance) {
        task_ = before;
        share *= 0.5;
        continue;
      }
      q_ = trial;
      const bool settled = distance - nearer < kMinGain * share * distance;
      distance = nearer;
      share = std::min(2.0 * share, first);
      if (settled) break;
    }
  }

  const JointArray& q() const { return q_; }
  const Task<M>& task() const { return task_; }
  int iterations() const { return iterations_; }

 private:
  // Of the tool while the arm moves, m and rad, however coarse the tolerance of the target.
  static constexpr double kHold = 2e-7;
  static constexpr int kHoldSteps = 20;
  static constexpr int kBackSteps = 5;

  int joints() const { return chain_.joints(); }

  // Projects q onto the target; false if that fails.
  bool hold(JointArray& q, int steps) {
    PoseDescent<M, Target> descent(chain_, target_, bounds_, q);
    if (!descent.task().within(tolerance_)) {
      iterations_ += descent.run(tolerance_, steps).iterations;
      if (!descent.task().within(tolerance_)) return false;
    }
    q = descent.q();
    task_ = descent.task();
    return true;
  }

  JointArray moved(const SelfMotionGoal& goal, double share) const {
    // Regular when joints are held; otherwise its remainder of the pull moves the tool by less than
    // rounding would.
    constexpr double kUndamped = 1e-12;  // m^2
    const int n = joints();
    JointArray pull{};
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i)
      if (goal.pulled[i]) pull[i] = share * (goal.q[i] - q_[i]);
    return moved_in(bounds_, q_,
                    boxed_step(task_, n, kUndamped, pull, changes_into(bounds_, q_, n)), n);
  }

  double distance_to(const SelfMotionGoal& goal, const JointArray& q) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(joints()); ++i)
      if (goal.pulled[i]) sum += (goal.q[i] - q[i]) * (goal.q[i] - q[i]);
    return sum;
  }

  const Chain& chain_;
  const Target& target_;
  const JointBox& bounds_;
  IkTolerance tolerance_;
  JointArray q_;
  Task<M> task_;  // at q_
  int iterations_ = 0;
};

}  // namespace leadthrough
