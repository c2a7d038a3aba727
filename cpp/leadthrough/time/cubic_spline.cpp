#include "leadthrough/time/cubic_spline.hpp"

#include <cmath>
#include <utility>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

// Solves a tridiagonal system by elimination with row exchanges, as LAPACK's dgtsv; the diagonals
// are overwritten, the right side with the solution.
void solve_tridiagonal(VectorXd& below, VectorXd& diagonal, VectorXd& above, Rows& right) {
  const Index n = diagonal.size();
  for (Index i = 0; i + 1 < n; ++i) {
    check_interrupt(i);
    double further = 0.0;  // to the right of `above`, where rows are exchanged
    if (std::abs(diagonal[i]) < std::abs(below[i])) {
      std::swap(diagonal[i], below[i]);
      std::swap(above[i], diagonal[i + 1]);
      right.row(i).swap(right.row(i + 1));
      if (i + 2 < n) std::swap(further, above[i + 1]);
    }
    const double factor = below[i] / diagonal[i];
    diagonal[i + 1] -= factor * above[i];
    if (i + 2 < n && further != 0.0) above[i + 1] -= factor * further;
    right.row(i + 1) -= factor * right.row(i);
    below[i] = further;
  }
  for (Index i = n - 1; i >= 0; --i) {
    check_interrupt(i);
    if (i + 1 < n) right.row(i) -= above[i] * right.row(i + 1);
    if (i + 2 < n) right.row(i) -= below[i] * right.row(i + 2);
    right.row(i) /= diagonal[i];
  }
}

// Slopes at four samples or more, or at two or more from rest to rest, given the steps between them
// and the slopes of the chords.
Rows slopes_of(const VectorXd& steps, const Rows& chords, SplineEnds ends) {
  const Index n = steps.size() + 1;
  VectorXd below(n - 1), diagonal(n), above(n - 1);
  Rows slopes(n, chords.cols());
  for (Index i = 1; i + 1 < n; ++i) {
    check_interrupt(i);
    below[i - 1] = steps[i];
    diagonal[i] = 2.0 * (steps[i - 1] + steps[i]);
    above[i] = steps[i - 1];
    slopes.row(i) = 3.0 * (steps[i] * chords.row(i - 1) + steps[i - 1] * chords.row(i));
  }
  if (ends == SplineEnds::kAtRest) {
    for (const Index row : {Index{0}, n - 1}) {
      slopes.row(row).setZero();
      diagonal[row] = 1.0;
    }
    above[0] = below[n - 2] = 0.0;
    solve_tridiagonal(below, diagonal, above, slopes);
    return slopes;
  }
  // The first three and the last three samples lie on one cubic each.
  const auto end = [&](Index row, Index outer, Index inner, double both) {
    const double far = steps[outer], near = steps[inner];
    slopes.row(row) =
        ((far + 2.0 * both) * near * chords.row(outer) + (far * far) * chords.row(inner)) / both;
    diagonal[row] = near;
    return both;
  };
  above[0] = end(0, 0, 1, steps[0] + steps[1]);
  below[n - 2] = end(n - 1, n - 2, n - 3, steps[n - 2] + steps[n - 3]);
  solve_tridiagonal(below, diagonal, above, slopes);
  return slopes;
}

// The same for three samples, on a parabola, or two, on a line.
Rows slopes_of_few(const VectorXd& steps, const Rows& chords) {
  if (chords.rows() == 1) return chords.replicate(2, 1);
  Rows slopes(3, chords.cols());
  slopes.row(1) = (steps[1] * chords.row(0) + steps[0] * chords.row(1)) / (steps[0] + steps[1]);
  slopes.row(0) = 2.0 * chords.row(0) - slopes.row(1);
  slopes.row(2) = 2.0 * chords.row(1) - slopes.row(1);
  return slopes;
}

VectorXd steps_of(const VectorRef& parameters) {
  const Index pieces = parameters.size() - 1;
  return parameters.tail(pieces) - parameters.head(pieces);
}

Rows chords_of(const VectorXd& steps, const RowsRef& q) {
  Rows chords = q.bottomRows(steps.size()) - q.topRows(steps.size());
  chords.array().colwise() /= steps.array();
  return chords;
}

}  // namespace

Rows spline_slopes(const VectorRef& parameters, const RowsRef& q, SplineEnds ends) {
  check_argument(q.rows() == parameters.size() && q.rows() > 1,
                 "q: expected one row for each of two parameters or more");
  const VectorXd steps = steps_of(parameters);
  const Rows chords = chords_of(steps, q);
  return steps.size() > 2 || ends == SplineEnds::kAtRest ? slopes_of(steps, chords, ends)
                                                         : slopes_of_few(steps, chords);
}

Rows cubic_through(const VectorRef& parameters, const RowsRef& q) {
  check_argument(q.rows() == parameters.size() && q.rows() > 1,
                 "q: expected one row for each of two parameters or more");
  const VectorXd steps = steps_of(parameters);
  const Index pieces = steps.size();
  const Rows chords = chords_of(steps, q);
  const Rows slopes = spline_slopes(parameters, q, SplineEnds::kSmooth);
  Rows table(4 * pieces, q.cols());
  for (Index i = 0; i < pieces; ++i) {
    check_interrupt(i);
    const Eigen::RowVectorXd bend =
        (slopes.row(i) + slopes.row(i + 1) - 2.0 * chords.row(i)) / steps[i];
    table.row(4 * i) = q.row(i);
    table.row(4 * i + 1) = slopes.row(i);
    table.row(4 * i + 2) = (chords.row(i) - slopes.row(i)) / steps[i] - bend;
    table.row(4 * i + 3) = bend / steps[i];
  }
  return table;
}

}  // namespace leadthrough
