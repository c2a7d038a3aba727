#pragma once

// Smooth paths through samples, within a tolerance.

#include <vector>

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

// Pieces of degree 5 with four continuous derivatives; see PolynomialPath. No breaks if there are
// too few samples for the tolerance.
struct SplineFit {
  std::vector<Eigen::Index> breaks;  // samples at which pieces begin and end
  Rows coefficients;
};

// Lower and upper bounds of the path, a value a column; infinite where there is none.
struct CurveBounds {
  Eigen::VectorXd lower, upper;
};

// A least-squares fit with as few pieces as the tolerance allows: those that miss a sample by more
// are halved. parameters: increasing, more than six, of the rows of q. The ends are
// interpolated. corners: whether pieces around a corner may be as short as from sample to sample,
// which they pass there; without, no breaks if pieces would have fewer than three.
SplineFit fit_spline(const VectorRef& parameters, const RowsRef& q, double tolerance, bool corners);

// A penalized fit (Eilers and Marx 1996): of each column the smallest third derivative, in the mean
// square, that leaves no sample by more than the tolerance, to a quarter of a power of ten of its
// weight. Arguments as before; the path is inside the bounds.
SplineFit smooth_spline(const VectorRef& parameters, const RowsRef& q, double tolerance,
                        const CurveBounds& bounds);

// The first row, and every row that differs from the last one found by more than the tolerance in
// some column.
std::vector<Eigen::Index> rows_apart(const RowsRef& q, double tolerance);

}  // namespace leadthrough
