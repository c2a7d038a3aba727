#pragma once

#include <atomic>
#include <chrono>
#include <exception>

namespace leadthrough {

// Thrown out of a computation that its caller wants to end.
struct Interrupted : std::exception {
  const char* what() const noexcept override { return "interrupted"; }
};

class Interruptible;

// The computation of a thread, and the checks until it looks again: a look takes as long as ten.
struct InterruptWatch {
  static constexpr int kChecksPerLook = 16;

  Interruptible* call = nullptr;
  bool is_caller = false;
  int checks_left = kChecksPerLook;
};

inline thread_local InterruptWatch interrupt_watch;

// While it lives, check_interrupt() on this thread throws once `is_wanted` is true. That is asked
// on this thread only, a few times per second.
class Interruptible {
 public:
  explicit Interruptible(bool (*is_wanted)()) : is_wanted_(is_wanted), outer_(interrupt_watch) {
    interrupt_watch = {this, true, InterruptWatch::kChecksPerLook};
  }
  ~Interruptible() { interrupt_watch = outer_; }
  Interruptible(const Interruptible&) = delete;
  Interruptible& operator=(const Interruptible&) = delete;

  void look(bool is_caller) {
    if (is_caller && is_due() && is_wanted_()) stop_ = true;
    if (stop_.load(std::memory_order_relaxed)) throw Interrupted();
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kInterval{50};

  // False for the first interval: most computations are shorter.
  bool is_due() {
    const Clock::time_point now = Clock::now();
    if (now < next_) return false;
    const bool is_first = next_ == Clock::time_point();
    next_ = now + kInterval;
    return !is_first;
  }

  bool (*is_wanted_)();
  InterruptWatch outer_;
  Clock::time_point next_{};
  std::atomic<bool> stop_{false};
};

// Out of line: loops that hardly ever look stay as small, and as quick, as without it.
[[gnu::noinline, gnu::cold]] inline void look_for_interrupt() {
  InterruptWatch& watch = interrupt_watch;
  watch.checks_left = InterruptWatch::kChecksPerLook;
  if (watch.call) watch.call->look(watch.is_caller);
}

// Throws Interrupted if the caller wants the computation to end. Long loops call it, at least every
// few milliseconds.
inline void check_interrupt() {
  if (--interrupt_watch.checks_left <= 0) look_for_interrupt();
}

// The same for loops whose turns take less than some hundred nanoseconds, by the turn's number.
[[gnu::noinline, gnu::cold]] inline void check_interrupt_of_many() { check_interrupt(); }

template <typename Count>
void check_interrupt(Count turn) {
  if (turn % 256 == 0) check_interrupt_of_many();
}

}  // namespace leadthrough
