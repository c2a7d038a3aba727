#pragma once

#include <algorithm>
#include <cmath>

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

// Rotates two columns in their plane.
template <typename Matrix>
void rotate_columns(Matrix&& a, Eigen::Index p, Eigen::Index q, double cosine, double sine) {
  const auto old = a.col(p).eval();
  a.col(p) = cosine * old - sine * a.col(q);
  a.col(q) = sine * old + cosine * a.col(q);
}

// One-sided Jacobi, Hestenes 1958, "Inversion of matrices by biorthogonalization": rotates pairs of
// columns of `a` until all are orthogonal, and calls rotated(p, q, cosine, sine) for each rotation.
// The lengths of the columns are the singular values; the small ones keep their digits (Demmel and
// Veselic 1992), and a matrix of a few columns takes a few sweeps. Columns not longer than
// `negligible` are unchanged.
template <typename Matrix, typename Rotated>
void orthogonalize_columns(Matrix&& a, double negligible, const Rotated& rotated) {
  constexpr double kOrthogonal = 1e-15;
  constexpr int kMaxSweeps = 40;
  const double least = negligible * negligible;
  bool done = false;
  for (int sweep = 0; sweep < kMaxSweeps && !done; ++sweep) {
    done = true;
    for (Eigen::Index p = 0; p + 1 < a.cols(); ++p)
      for (Eigen::Index q = p + 1; q < a.cols(); ++q) {
        const double pp = a.col(p).squaredNorm(), qq = a.col(q).squaredNorm();
        const double across = a.col(p).dot(a.col(q));
        if (std::min(pp, qq) <= least) continue;
        if (std::abs(across) <= kOrthogonal * std::sqrt(pp * qq)) continue;
        done = false;
        const double zeta = (qq - pp) / (2.0 * across);
        const double size = std::abs(zeta) + std::sqrt(1.0 + zeta * zeta);
        const double tangent = std::copysign(1.0, zeta) / size;
        const double cosine = 1.0 / std::sqrt(1.0 + tangent * tangent), sine = cosine * tangent;
        rotate_columns(a, p, q, cosine, sine);
        rotated(p, q, cosine, sine);
      }
  }
}

// The same, rotating the columns of `v` along: from v = I on, A V = W is the singular value
// decomposition of A, with the right singular vectors in V's columns.
template <typename A, typename V>
void orthogonalize_columns(A& a, V& v) {
  orthogonalize_columns(a, 0.0, [&](Eigen::Index p, Eigen::Index q, double cosine, double sine) {
    rotate_columns(v, p, q, cosine, sine);
  });
}

}  // namespace leadthrough
