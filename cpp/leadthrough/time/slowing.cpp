#include "leadthrough/time/slowing.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

// Along the path's own time s the arm runs at the speed ds/dt = sigma <= 1. With x = sigma^2 at the
// samples and u = x' / 2 between them, a joint's acceleration q' u + q'' x is linear in both. Row k
// of `slope` is q' between samples k - 1 and k, with standing still at both ends; `bend` is q''.
class PathSpeed {
 public:
  PathSpeed(const VectorRef& times, const RowsRef& q, const VectorRef& velocity,
            const VectorRef& acceleration)
      : last_(q.rows() - 1),
        joints_(q.cols()),
        acceleration_(acceleration),
        step_(last_ + 2),
        slope_(Rows::Zero(last_ + 2, joints_)),
        bend_(last_ + 1, joints_),
        cap_(Eigen::VectorXd::Ones(last_ + 1)),
        most_(last_ + 1),
        x_(last_ + 1),
        share_(cap_),
        interval_(last_ + 2) {
    for (Eigen::Index k = 1; k <= last_; ++k) {
      step_[k] = times[k] - times[k - 1];
      slope_.row(k) = (q.row(k) - q.row(k - 1)) / step_[k];
    }
    step_[0] = step_[1];
    step_[last_ + 1] = step_[last_];
    for (Eigen::Index k = 0; k <= last_; ++k)
      bend_.row(k) = 2.0 * (slope_.row(k + 1) - slope_.row(k)) / (step_[k] + step_[k + 1]);
    bound_by(velocity);
  }

  // The joint that must not move and does, or -1.
  int stuck() const { return stuck_; }

  // Runs as fast as it may; measured on the samples, an acceleration may still come out too large
  // where the path bends sharply: there, and only there, it is tightened.
  void solve() {
    constexpr int kRounds = 20;
    constexpr double kOvershoot = 1.001;  // so that the rounds end
    for (int round = 0; round < kRounds; ++round) {
      reach_back();
      run_forward();
      double worst = 0.0;
      for (Eigen::Index k = 0; k <= last_; ++k) {
        check_interrupt(k);
        const double ratio = excess(k);
        worst = std::max(worst, ratio);
        if (ratio > 1.0) share_[k] /= kOvershoot * ratio;
      }
      slowing_ = std::sqrt(std::max(1.0, worst));
      if (worst <= 1.0) break;
    }
  }

  double interval(Eigen::Index k) const { return slowing_ * interval_[k]; }

 private:
  void bound_by(const VectorRef& velocity) {
    for (Eigen::Index k = 1; k <= last_; ++k)
      for (Eigen::Index i = 0; i < joints_; ++i) {
        const double rate = std::abs(slope_(k, i));
        if (rate <= velocity[i]) continue;
        if (velocity[i] <= 0.0 || acceleration_[i] <= 0.0) stuck_ = static_cast<int>(i);
        const double sigma = velocity[i] / rate;
        cap_[k - 1] = std::min(cap_[k - 1], sigma * sigma);
        cap_[k] = std::min(cap_[k], sigma * sigma);
      }
    for (Eigen::Index i = 0; i < joints_; ++i)
      if (acceleration_[i] <= 0.0 && !slope_.col(i).isZero(0.0)) stuck_ = static_cast<int>(i);
  }

  struct Range {
    double lower, upper;
    bool empty() const { return lower > upper; }
    // Keeps the u with |a u + b| <= limit.
    void keep(double a, double b, double limit) {
      if (a == 0.0) {
        if (std::abs(b) > limit) lower = kInfinity;
        return;
      }
      const double p = (-limit - b) / a, q = (limit - b) / a;
      lower = std::max(lower, std::min(p, q));
      upper = std::min(upper, std::max(p, q));
    }
  };

  // The u that lead from x at sample k to at most `next` at the one after.
  Range choices(Eigen::Index k, double x, double next) const {
    const double twice = 2.0 * step_[k + 1];
    Range range{-x / twice, (next - x) / twice};
    for (Eigen::Index i = 0; i < joints_; ++i) {
      const double slope = slope_(k + 1, i), bend = bend_(k + 1, i);
      range.keep(slope, bend_(k, i) * x, share_[k] * acceleration_[i]);
      range.keep(slope + twice * bend, bend * x, share_[k + 1] * acceleration_[i]);
    }
    return range;
  }

  // The largest x at each sample from which the rest of the path can be run.
  void reach_back() {
    constexpr int kBisections = 60;
    most_[last_] = end_cap();
    for (Eigen::Index k = last_ - 1; k >= 0; --k) {
      check_interrupt();
      most_[k] = cap_[k];
      if (!choices(k, most_[k], most_[k + 1]).empty()) continue;
      double good = 0.0, bad = most_[k];  // standing still is always possible
      for (int i = 0; i < kBisections; ++i) {
        const double x = 0.5 * (good + bad);
        (choices(k, x, most_[k + 1]).empty() ? bad : good) = x;
      }
      most_[k] = good;
    }
  }

  // At the ends the path bends from and into standing still.
  double end_cap() const { return std::min(cap_[last_], bend_cap(last_)); }
  double bend_cap(Eigen::Index k) const {
    double cap = kInfinity;
    for (Eigen::Index i = 0; i < joints_; ++i)
      if (bend_(k, i) != 0.0)
        cap = std::min(cap, share_[k] * acceleration_[i] / std::abs(bend_(k, i)));
    return cap;
  }

  void run_forward() {
    x_[0] = std::min(most_[0], bend_cap(0));
    for (Eigen::Index k = 0; k < last_; ++k) {
      check_interrupt(k);
      const double u = choices(k, x_[k], most_[k + 1]).upper;
      x_[k + 1] = std::clamp(x_[k] + 2.0 * step_[k + 1] * u, 0.0, most_[k + 1]);
      interval_[k + 1] = 2.0 * step_[k + 1] / (std::sqrt(x_[k]) + std::sqrt(x_[k + 1]));
    }
    interval_[0] = interval_[1];
    interval_[last_ + 1] = interval_[last_];
  }

  // The largest acceleration around sample k, in units of its limit.
  double excess(Eigen::Index k) const {
    const double before = step_[k] / interval_[k], after = step_[k + 1] / interval_[k + 1];
    const double time = 0.5 * (interval_[k] + interval_[k + 1]);
    double worst = 0.0;
    for (Eigen::Index i = 0; i < joints_; ++i) {
      const double change = std::abs(slope_(k + 1, i) * after - slope_(k, i) * before);
      if (change > 0.0) worst = std::max(worst, change / (time * acceleration_[i]));
    }
    return worst;
  }

  Eigen::Index last_, joints_;
  Eigen::VectorXd acceleration_;
  Eigen::VectorXd step_;
  Rows slope_, bend_;
  Eigen::VectorXd cap_, most_, x_, share_, interval_;
  double slowing_ = 1.0;
  int stuck_ = -1;
};

}  // namespace

Slowing slow_down(const VectorRef& times, const RowsRef& q, const VectorRef& velocity,
                  const VectorRef& acceleration) {
  check_argument(times.size() > 0 && q.rows() == times.size(), "q: expected one row for each time");
  check_argument(velocity.size() == q.cols() && acceleration.size() == q.cols(),
                 "velocity, acceleration: expected one limit a joint");
  Slowing result{times};
  if (q.rows() < 2) return result;
  PathSpeed speed(times, q, velocity, acceleration);
  result.stuck = speed.stuck();
  if (result.stuck >= 0) return result;
  speed.solve();
  for (Eigen::Index k = 1; k < times.size(); ++k)
    result.times[k] = result.times[k - 1] + speed.interval(k);
  return result;
}

}  // namespace leadthrough
