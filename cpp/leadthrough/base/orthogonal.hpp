#pragma once

#include <cmath>
#include <limits>

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

// One-sided Jacobi, Hestenes 1958, "Inversion of matrices by biorthogonalization": rotates pairs of
// columns of `a` until all are orthogonal, and those of `v` with them. From v = I follows A V = W,
// the singular value decomposition of A: the lengths of W's columns are the singular values, V's
// columns the right singular vectors. Small singular values keep their digits (Demmel and Veselic
// 1992), and a matrix of a few columns takes a few sweeps.
template <typename A, typename V>
void orthogonalize_columns(A& a, V& v) {
  constexpr double kOrthogonal = 4.0 * std::numeric_limits<double>::epsilon();
  constexpr int kMaxSweeps = 40;
  bool rotated = true;
  for (int sweep = 0; rotated && sweep < kMaxSweeps; ++sweep) {
    rotated = false;
    for (Eigen::Index q = 1; q < a.cols(); ++q)
      for (Eigen::Index p = 0; p < q; ++p) {
        const double across = a.col(p).dot(a.col(q));
        const double pp = a.col(p).squaredNorm(), qq = a.col(q).squaredNorm();
        if (std::abs(across) <= kOrthogonal * std::sqrt(pp * qq)) continue;
        rotated = true;
        const double zeta = (qq - pp) / (2.0 * across);
        const double tangent = std::copysign(1.0 / (std::abs(zeta) + std::hypot(1.0, zeta)), zeta);
        const double cosine = 1.0 / std::hypot(1.0, tangent), sine = cosine * tangent;
        const auto turn = [&](auto& matrix) {
          for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
            const double left = matrix(row, p), right = matrix(row, q);
            matrix(row, p) = cosine * left - sine * right;
            matrix(row, q) = sine * left + cosine * right;
          }
        };
        turn(a);
        turn(v);
      }
  }
}

}  // namespace leadthrough
