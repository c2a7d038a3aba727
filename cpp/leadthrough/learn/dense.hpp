#pragma once

// Products and solutions of dense systems in one thread: the rounding of BLAS libraries depends on
// the number of threads.

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

Rows product(const RowsRef& left, const RowsRef& right);

// The X with matrix * X = right, for a symmetric matrix of which the lower half is read; empty if
// it is not positive definite.
Rows solve_definite(const RowsRef& matrix, const RowsRef& right);

}  // namespace leadthrough
