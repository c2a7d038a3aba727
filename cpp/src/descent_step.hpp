#pragma once

// The monotone iteration towards one target, inside absolute bounds, that paths are made of.

#include "damped_step.hpp"

namespace leadthrough {

struct DescentBounds {
  JointArray lower, upper;
};

struct DescentEnd {
  IkStatus status = IkStatus::kBudget;
  double position_error = 0.0;
  double orientation_error = 0.0;
  int iterations = 0;
};

// Keeps the damped matrix regular at singularities: (1 mm)^2, for a full step of a joint that
// moves the tip 1 m a rad a bias of a millionth.
constexpr double kDampingFloor = 1e-6;

// Moves q, which must lie inside the bounds. Takes at least one step, so that a slow path is
// followed smoothly and not in jerks of the tolerance's size. `rest` biases the first step only:
// the self-motion that it asks for, as far as the task allows.
template <int M>
DescentEnd descend(const Chain& chain, const IkTarget& target, const DescentBounds& bounds,
                   const JointArray& rest, const IkTolerance& tolerance, int max_iterations,
                   JointArray& q) {
  // Less progress than this a step is none.
  constexpr double kLeastProgress = 1e-3;
  constexpr int kRetries = 6;
  const int n = chain.joints();
  const auto count = static_cast<std::size_t>(n);
  std::array<Task<M>, 2> tasks;
  Task<M>* now = &tasks[0];
  Task<M>* next = &tasks[1];
  evaluate(chain, target, q.data(), *now);

  JointArray zero{};
  bool resting = std::all_of(rest.begin(), rest.begin() + n, [](double r) { return r == 0.0; });
  DescentEnd end;
  double caution = 1.0;
  int retries = 0;
  while (end.iterations < max_iterations) {
    if (end.iterations > 0 && now->within(tolerance)) {
      end.status = IkStatus::kConverged;
      break;
    }
    JointArray lower, upper, step, moved;
    for (std::size_t i = 0; i < count; ++i) {
      lower[i] = bounds.lower[i] - q[i];
      upper[i] = bounds.upper[i] - q[i];
    }
    const double squared = now->squared();
    const double damping = caution * (kErrorDamping * squared + kDampingFloor);
    boxed_step(*now, n, damping, resting ? zero : rest, lower, upper, step);
    for (std::size_t i = 0; i < count; ++i)
      moved[i] = std::clamp(q[i] + step[i], bounds.lower[i], bounds.upper[i]);
    evaluate(chain, target, moved.data(), *next);
    ++end.iterations;
    const bool falls = next->squared() < squared || next->within(tolerance);
    if (!falls && resting) {
      if (++retries > kRetries) {
        end.status = IkStatus::kStalled;
        break;
      }
      caution *= 10.0;
      continue;
    }
    if (falls) {
      const bool stalled =
          resting && !next->within(tolerance) && next->squared() > (1.0 - kLeastProgress) * squared;
      q = moved;
      std::swap(now, next);
      caution = 1.0;
      retries = 0;
      if (stalled) {
        end.status = IkStatus::kStalled;
        break;
      }
    }
    resting = true;
  }
  if (now->within(tolerance)) end.status = IkStatus::kConverged;
  end.position_error = now->position_error;
  end.orientation_error = now->orientation_error;
  return end;
}

}  // namespace leadthrough
