#pragma once

// Geometric Jacobians at the tip, linear rows first, base frame, and their derivatives in time
// along a motion q(t). With the tip's velocity x' = J q': x'' = J q'' + J' q' and
// x''' = J q''' + 2 J' q'' + J'' q'.

#include "leadthrough/arm/chain.hpp"

namespace leadthrough {

// q, qd, qdd: one value a joint; rad or m, per second, per second squared.
void jacobian_derivative(const Chain& chain, const double* q, const double* qd,
                         JacobianColumns& derivative);
void jacobian_second_derivative(const Chain& chain, const double* q, const double* qd,
                                const double* qdd, JacobianColumns& derivative);

// One configuration a row of the arguments; a row of the result holds a matrix (6, joints) by rows.
Rows jacobian_batch(const Chain& chain, const RowsRef& q);
Rows jacobian_derivative_batch(const Chain& chain, const RowsRef& q, const RowsRef& qd);
Rows jacobian_second_derivative_batch(const Chain& chain, const RowsRef& q, const RowsRef& qd,
                                      const RowsRef& qdd);

}  // namespace leadthrough
