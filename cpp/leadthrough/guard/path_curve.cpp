#include "leadthrough/guard/path_curve.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/base/argument.hpp"

namespace leadthrough::guard {

using Eigen::Index;

JointQuintic::JointQuintic(double duration, const JointState& start, const JointState& end)
    : duration_(duration) {
  const double h = duration;
  auto& c = coefficients_;
  c = {start.position, h * start.velocity, 0.5 * h * h * start.acceleration};
  const double d = end.position - start.position - c[1] - c[2];
  const double v = h * (end.velocity - start.velocity) - 2.0 * c[2];
  const double a = h * h * end.acceleration - 2.0 * c[2];
  c[3] = 10.0 * d - 4.0 * v + 0.5 * a;
  c[4] = -15.0 * d + 7.0 * v - a;
  c[5] = 6.0 * d - 3.0 * v + 0.5 * a;
}

JointState JointQuintic::at(double u) const {
  const auto& c = coefficients_;
  const double position = c[0] + u * (c[1] + u * (c[2] + u * (c[3] + u * (c[4] + u * c[5]))));
  const double slope =
      c[1] + u * (2.0 * c[2] + u * (3.0 * c[3] + u * (4.0 * c[4] + u * 5.0 * c[5])));
  const double curve = 2.0 * c[2] + u * (6.0 * c[3] + u * (12.0 * c[4] + u * 20.0 * c[5]));
  const double h = duration_;
  return {position, slope / h, curve / (h * h)};
}

namespace {

// The state at the middle one of three samples, by the parabola through them.
JointState middle(double before, double here, double after, double h0, double h1) {
  const double s0 = (here - before) / h0, s1 = (after - here) / h1;
  return {here, (s0 * h1 + s1 * h0) / (h0 + h1), 2.0 * (s1 - s0) / (h0 + h1)};
}

JointState shifted(const JointState& state, double position, double time) {
  return {position, state.velocity + time * state.acceleration, state.acceleration};
}

// A single sample: the parabola through it and the two samples before, if the state lies on one.
JointState next_after(const JointState& state, double position, double h) {
  const double coasting = state.position + h * (state.velocity + 0.5 * h * state.acceleration);
  const double off = (position - coasting) / h;
  return {position, state.velocity + h * state.acceleration + 1.5 * off,
          state.acceleration + off / h};
}

}  // namespace

Rows with_rates(const Eigen::VectorXd& times, const RowsRef& positions, const RowsRef& start,
                double period) {
  check_argument(positions.size() > 0 && times.size() == positions.rows(),
                 "positions: expected one row for each time");
  check_argument(start.rows() <= 1 && start.cols() == 3 * positions.cols(),
                 "start: expected one state or none");
  check_argument(period > 0.0, "period: expected a positive time");
  const Index n = positions.rows(), joints = positions.cols();
  Rows result = Rows::Zero(n, 3 * joints);
  const bool begun = start.rows() > 0;
  for (Index j = 0; j < joints; ++j) {
    for (Index k = begun ? 0 : 1; k + 1 < n; ++k) {
      const double before = k > 0 ? positions(k - 1, j) : start(0, j);
      const double h = k > 0 ? times[k] - times[k - 1] : period;
      put(middle(before, positions(k, j), positions(k + 1, j), h, times[k + 1] - times[k]), j,
          result.row(k));
    }
    if (n == 1) {
      const JointState rest{positions(0, j), 0.0, 0.0};
      put(begun ? next_after(joint_state(start, 0, j), rest.position, period) : rest, j,
          result.row(0));
      continue;
    }
    const double first = times[1] - times[0], last = times[n - 1] - times[n - 2];
    const JointState line{positions(0, j), (positions(1, j) - positions(0, j)) / first, 0.0};
    if (!begun)
      put(n == 2 ? line : shifted(joint_state(result, 1, j), line.position, -first), j,
          result.row(0));
    put(shifted(joint_state(result, n - 2, j), positions(n - 1, j), last), j, result.row(n - 1));
  }
  return result;
}

}  // namespace leadthrough::guard
