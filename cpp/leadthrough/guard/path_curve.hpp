#pragma once

// The curve through states of a stream: quintics, at the parameters 0, 1, 2, ...

#include <algorithm>
#include <array>
#include <cmath>

#include "leadthrough/guard/step_limits.hpp"

namespace leadthrough::guard {

// One joint between two states, as a polynomial in the fraction of the step.
class JointQuintic {
 public:
  JointQuintic(double duration, const JointState& start, const JointState& end);

  JointState at(double fraction) const;
  double coefficient(std::size_t k) const { return coefficients_[k]; }

 private:
  double duration_;
  std::array<double, 6> coefficients_;
};

// Of two states or more.
class PathCurve {
 public:
  PathCurve(const RowsRef& states, double period);

  // The state at a place that is passed at `rate` rows a period, with the derivative `bend` of that
  // rate; at a row, exactly its position.
  template <typename Row>
  void at(double place, double rate, double bend, Row row) const {
    const Eigen::Index joints = states_.cols() / 3;
    const auto last = static_cast<double>(states_.rows() - 2);
    // The comparison takes a place that is no number as the first.
    const auto i = static_cast<Eigen::Index>(place > 0.0 ? std::min(std::floor(place), last) : 0.0);
    const double u = place - static_cast<double>(i);
    if (u == 0.0 || u == 1.0) return timed(states_.row(u == 0.0 ? i : i + 1), rate, bend, row);
    const auto c = [&](Eigen::Index k) { return coefficients_.row(6 * i + k); };
    row.head(joints) = c(0) + u * (c(1) + u * (c(2) + u * (c(3) + u * (c(4) + u * c(5)))));
    auto slope = row.segment(joints, joints);
    slope = c(1) + u * (2.0 * c(2) + u * (3.0 * c(3) + u * (4.0 * c(4) + u * 5.0 * c(5))));
    row.tail(joints) = rate * rate / (period_ * period_) *
                           (2.0 * c(2) + u * (6.0 * c(3) + u * (12.0 * c(4) + u * 20.0 * c(5)))) +
                       bend / (period_ * period_) * slope;
    slope *= rate / period_;
  }

 private:
  template <typename State, typename Row>
  void timed(const State& state, double rate, double bend, Row row) const {
    const Eigen::Index joints = state.size() / 3;
    row.head(joints) = state.head(joints);
    row.segment(joints, joints) = rate * state.segment(joints, joints);
    row.tail(joints) =
        rate * rate * state.tail(joints) + bend / period_ * state.segment(joints, joints);
  }

  RowsRef states_;
  double period_;
  Rows coefficients_;  // (6 steps, joints)
};

// Rates of positions (n, joints) at times: those of the parabola through a sample and its
// neighbours; at an end, of the parabola through the three there. `start`, if it has a row, is the
// state a period before the first sample; a single sample then takes the parabola that goes on from
// there. Returns states (n, 3 joints).
Rows with_rates(const Eigen::VectorXd& times, const RowsRef& positions, const RowsRef& start,
                double period);

}  // namespace leadthrough::guard
