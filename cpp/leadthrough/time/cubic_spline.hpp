#pragma once

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

// At the second row and the last but one the third derivative is continuous ("not a knot"), so that
// three rows make a parabola and two a line; or both ends have no slope.
enum class SplineEnds { kSmooth, kAtRest };

// SciPy's CubicSpline takes ten times as long for 600,000 rows: missing rates of every motion and
// the time law of long recordings are computed here.

// Slopes at the rows of q of the cubic spline through them, at increasing parameters, two or more.
Rows spline_slopes(const VectorRef& parameters, const RowsRef& q, SplineEnds ends);

// The same spline with smooth ends: a row for each coefficient of each piece, as in PolynomialPath.
Rows cubic_through(const VectorRef& parameters, const RowsRef& q);

}  // namespace leadthrough
