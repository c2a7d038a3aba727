#pragma once

// Points of curves at many times, one row a time, in powers of time and in Bernstein's form.

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

// Derivatives of an order of polynomial pieces, 0 for values. Piece p spans knots[p] to
// knots[p + 1], the outer ones also what is beyond; its coefficients of (t - knots[p])^k, k rising,
// are the rows from p * terms on. Sums powers in rising order, as SciPy's PPoly does.
Rows polynomial_values(const VectorRef& knots, const RowsRef& coefficients, const VectorRef& times,
                       int order);

// The Bezier curve of control points, the rows, at fractions of its domain.
Rows bezier_values(const RowsRef& points, const VectorRef& fractions);

}  // namespace leadthrough
