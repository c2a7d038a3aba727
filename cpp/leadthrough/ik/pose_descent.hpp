#pragma once

// The monotone iteration towards one target, inside absolute bounds: the building block of paths.

#include <utility>

#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/ik/damped_step.hpp"

namespace leadthrough {

struct DescentEnd {
  IkStatus status = IkStatus::kBudget;
  double position_error = 0.0;
  double orientation_error = 0.0;
  int iterations = 0;
};

template <int M, typename Target = IkTarget>
class PoseDescent {
 public:
  // `q` must lie inside the bounds. All arguments must outlive the descent.
  PoseDescent(const Chain& chain, const Target& target, const JointBox& bounds, const JointArray& q)
      : chain_(chain), target_(target), bounds_(bounds), q_(q) {
    evaluate(chain_, target_, q_.data(), *now_);
  }

  const JointArray& q() const { return q_; }
  const Task<M>& task() const { return *now_; }

  // One step towards the target that also moves by `pull` in the task's null space.
  void pull(const JointArray& pull) {
    propose(pull, 1.0);
    take();
  }

  // Steps while the error falls, at least one: a slow path is then followed smoothly and not in
  // jumps of the tolerance's size.
  DescentEnd run(const IkTolerance& tolerance, int max_iterations) {
    IkStatus status = IkStatus::kBudget;
    const int last = iterations_ + max_iterations;
    do {
      check_interrupt();
      const double before = now_->squared();
      if (!improve(tolerance)) {
        status = IkStatus::kUnreachable;
        break;
      }
      constexpr double kMinProgress = 1e-3;  // relative decrease in a step that counts
      const bool slow = now_->squared() > (1.0 - kMinProgress) * before;
      if (slow) status = IkStatus::kUnreachable;
    } while (status == IkStatus::kBudget && !now_->within(tolerance) && iterations_ < last);
    if (now_->within(tolerance)) status = IkStatus::kConverged;
    return {status, now_->position_error, now_->orientation_error, iterations_};
  }

 private:
  // Takes a step that lowers the error, with growing damping; false if none does.
  bool improve(const IkTolerance& tolerance) {
    constexpr double kMaxCaution = 1e6;
    for (double caution = 1.0; caution <= kMaxCaution; caution *= 10.0) {
      propose({}, caution);
      if (next_->squared() < now_->squared() || next_->within(tolerance)) {
        take();
        return true;
      }
    }
    return false;
  }

  void propose(const JointArray& rest, double caution) {
    const int n = chain_.joints();
    const double damping = caution * (kErrorDamping * now_->squared() + kDampingFloor);
    const JointArray step = boxed_step(*now_, n, damping, rest, changes_into(bounds_, q_, n));
    moved_ = moved_in(bounds_, q_, step, n);
    evaluate(chain_, target_, moved_.data(), *next_);
    ++iterations_;
  }

  void take() {
    q_ = moved_;
    std::swap(now_, next_);
  }

  const Chain& chain_;
  const Target& target_;
  const JointBox& bounds_;
  JointArray q_;
  JointArray moved_{};
  std::array<Task<M>, 2> tasks_;
  Task<M>* now_ = &tasks_[0];
  Task<M>* next_ = &tasks_[1];
  int iterations_ = 0;
};

}  // namespace leadthrough
