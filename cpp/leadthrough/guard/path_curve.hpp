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

 private:
  double duration_;
  std::array<double, 6> coefficients_;
};

// Of two states or more. Coefficients are computed where they are asked for: those of a long motion
// would take twice its memory.
class PathCurve {
 public:
  PathCurve(const RowsRef& states, double period) : states_(states), period_(period) {}

  // The state at a place that is passed at `rate` rows a period, with the derivative `bend` of that
  // rate; at a row, exactly its position.
  template <typename Row>
  void at(double place, double rate, double bend, Row row) const {
    const auto last = static_cast<double>(states_.rows() - 2);
    // The comparison takes a place that is no number as the first.
    const auto i = static_cast<Eigen::Index>(place > 0.0 ? std::min(std::floor(place), last) : 0.0);
    const double u = place - static_cast<double>(i);
    for (Eigen::Index j = 0; j < states_.cols() / 3; ++j) {
      const JointState here = passed(i, j, u);
      put({here.position, rate * here.velocity,
           rate * rate * here.acceleration + bend / period_ * here.velocity},
          j, row);
    }
  }

 private:
  JointState passed(Eigen::Index row, Eigen::Index joint, double u) const {
    const JointState start = joint_state(states_, row, joint);
    const JointState end = joint_state(states_, row + 1, joint);
    if (u == 0.0) return start;
    return u == 1.0 ? end : JointQuintic(period_, start, end).at(u);
  }

  RowsRef states_;
  double period_;
};

// Rates of positions (n, joints) at times: those of the parabola through a sample and its
// neighbours; at an end, of the parabola through the three there. `start`, if it has a row, is the
// state a period before the first sample; a single sample then takes the parabola that goes on from
// there. Returns states (n, 3 joints).
Rows with_rates(const Eigen::VectorXd& times, const RowsRef& positions, const RowsRef& start,
                double period);

}  // namespace leadthrough::guard
