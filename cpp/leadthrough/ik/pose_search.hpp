#pragma once

// The search for one target: attempts from the start and from random configurations, each stopped
// as soon as it gains little, until the budget is used up.

#include <ctime>

#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/ik/axis_task.hpp"
#include "leadthrough/ik/joint_ranges.hpp"
#include "leadthrough/ik/self_motion.hpp"

namespace leadthrough {

// CPU time of this thread, s. The wall clock would punish a busy machine.
inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

template <int M, typename Target>
class PoseSearch {
 public:
  // All arguments must outlive the search. `start` lies inside the limits.
  PoseSearch(const Chain& chain, const Target& target, const IkOptions& options,
             const JointVector& start, std::uint64_t stream)
      : chain_(chain),
        target_(target),
        options_(options),
        random_(options.seed, stream),
        n_(chain.joints()),
        limits_(position_limits(chain)),
        open_limits_(limits_),
        beyond_(distance_from(chain.fixed[0].position, target) >
                reach(chain) + (std::isfinite(options.tolerance.position)
                                    ? options.tolerance.position
                                    : 0.0)) {
    std::copy(start.data(), start.data() + n_, q_.begin());
    best_ = q_;
    for (int i = 0; i < n_; ++i) {
      const auto k = static_cast<std::size_t>(i);
      wraps_[k] = wraps(chain, i);
      if (!wraps_[k]) continue;
      open_limits_.lower[k] = -kInfinity;
      open_limits_.upper[k] = kInfinity;
    }
    if (std::isfinite(options.max_cpu_seconds))
      cpu_end_ = thread_seconds() + options.max_cpu_seconds;
  }

  // Runs the next attempt. False if there is none left, or if the budget ended it.
  bool attempt() {
    if (attempts_ > (beyond_ ? 0 : options_.max_restarts) || spent_) return false;
    if (attempts_++ > 0) q_ = random_configuration(chain_, random_);
    found_ = descend();
    if (!found_ && task_.squared() < least_) {
      least_ = task_.squared();
      best_ = q_;
    }
    return !spent_;
  }

  bool found() const { return found_; }
  bool redundant() const { return n_ > task_.rows; }
  int iterations() const { return iterations_; }

  // From the best attempt to the configuration at which a descent ends, and the reason why.
  IkStatus come_close(std::array<bool, kMaxJoints>& limiting) {
    constexpr int kLastSteps = 100;
    PoseDescent<M, Target> descent(chain_, target_, open_limits_, best_);
    const DescentEnd end = descent.run(options_.tolerance, kLastSteps);
    iterations_ += end.iterations;
    q_ = descent.q();
    for (std::size_t i = 0; i < count(); ++i)
      if (wraps_[i]) q_[i] = wrapped(q_[i], q_[i], limits_.lower[i], limits_.upper[i]);
    found_ = end.status == IkStatus::kConverged;
    task_ = descent.task();
    if (found_) return IkStatus::kConverged;
    if (beyond_) return IkStatus::kUnreachable;
    if (spent_) return IkStatus::kBudget;
    return press(limiting) ? IkStatus::kLimits : IkStatus::kUnreachable;
  }

  // Of the equivalent angles of a joint that wraps, the one nearest to `goal`.
  void take_turns_near(const JointVector& goal) {
    for (int i = 0; i < n_; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (wraps_[k]) q_[k] = wrapped(q_[k], goal[i], limits_.lower[k], limits_.upper[k]);
    }
  }

  // Moves a redundant arm towards the goal; the tool stays.
  void approach(const SelfMotionGoal& goal, double share) {
    if (!redundant()) return;
    SelfMotion<M, Target> motion(chain_, target_, limits_, options_.tolerance, q_);
    motion.run(goal, share, options_.max_iterations - iterations_);
    iterations_ += motion.iterations();
    q_ = motion.q();
    task_ = motion.task();
  }

  IkResult result(IkStatus status) const { return result_at(q_, n_, task_, status, iterations_); }

 private:
  // Steps until the target is met or two net steps gained less than 30 %.
  bool descend() {
    constexpr double kGoodStep = 0.7;
    constexpr int kPatience = 2;
    evaluate(chain_, target_, q_.data(), task_);
    int idle = 0;
    double attempt_least = task_.squared();
    while (!task_.within(options_.tolerance)) {
      check_interrupt();
      // Measured against the least error so far: a cycle makes no progress.
      if (idle >= kPatience || out_of_budget()) return false;
      move(boxed_step(task_, n_, kErrorDamping * task_.squared(), {},
                      changes_into(open_limits_, q_, n_)));
      evaluate(chain_, target_, q_.data(), task_);
      ++iterations_;
      idle = task_.squared() > kGoodStep * attempt_least ? idle + 1 : std::max(idle - 1, 0);
      attempt_least = std::min(attempt_least, task_.squared());
    }
    return true;
  }

  bool out_of_budget() {
    spent_ = iterations_ >= options_.max_iterations ||
             (cpu_end_ < kInfinity && thread_seconds() > cpu_end_);
    return spent_;
  }

  void move(const JointArray& step) {
    for (std::size_t i = 0; i < count(); ++i) {
      q_[i] += step[i];
      q_[i] = wraps_[i] ? wrapped(q_[i], q_[i], limits_.lower[i], limits_.upper[i])
                        : std::clamp(q_[i], limits_.lower[i], limits_.upper[i]);
    }
  }

  // Marks the joints whose limits prevent a decrease of the error; false if there are none.
  bool press(std::array<bool, kMaxJoints>& limiting) const {
    constexpr double kFirmly = 1e-3;  // cosine between the joint's effect and the error
    bool any = false;
    for (std::size_t i = 0; i < count(); ++i) {
      const double pull = task_.columns[i].dot(task_.error);
      const bool firm = std::abs(pull) > kFirmly * task_.columns[i].norm() * task_.error.norm();
      const bool barred =
          pull < 0.0 ? q_[i] <= open_limits_.lower[i] : q_[i] >= open_limits_.upper[i];
      limiting[i] = firm && barred;
      any = any || limiting[i];
    }
    return any;
  }

  std::size_t count() const { return static_cast<std::size_t>(n_); }

  const Chain& chain_;
  const Target& target_;
  const IkOptions& options_;
  RandomStream random_;
  int n_;
  JointBox limits_, open_limits_;  // of joints that wrap the latter are infinite
  bool beyond_;
  std::array<bool, kMaxJoints> wraps_{};
  JointArray q_{}, best_{};
  Task<M> task_;
  double least_ = kInfinity;
  double cpu_end_ = kInfinity;
  int iterations_ = 0;
  int attempts_ = 0;
  bool found_ = false;
  bool spent_ = false;
};

}  // namespace leadthrough
