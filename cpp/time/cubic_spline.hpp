#pragma once

#include "base/matrix.hpp"

namespace leadthrough {

// The cubic spline through the rows of q, at increasing parameters, two or more; its third
// derivative is continuous at the second and the last but one ("not a knot"), so that three rows
// make a parabola and two a line. A row for each coefficient of each piece, as in PolynomialPath.
Rows cubic_through(const Eigen::Ref<const Eigen::VectorXd>& parameters,
                   const Eigen::Ref<const Rows>& q);

}  // namespace leadthrough
