#include "time/polynomial_path.hpp"

#include <algorithm>

namespace leadthrough {

using Eigen::Index;

Index PolynomialPath::piece_of(double s, Index piece) const {
  while (piece > 0 && s < breaks[piece]) --piece;
  while (piece + 1 < pieces() && s >= breaks[piece + 1]) ++piece;
  return piece;
}

void PolynomialPath::position(double s, Index piece, double* q) const {
  const Index n = joints();
  const double h = s - breaks[piece];
  const double* row = coefficients.data() + (piece + 1) * terms() * n;
  std::fill(q, q + n, 0.0);
  for (Index k = terms(); k > 0; --k) {
    row -= n;
    for (Index j = 0; j < n; ++j) q[j] = q[j] * h + row[j];
  }
}

void PolynomialPath::position(double s, Index piece, double* q, double* first,
                              double* second) const {
  const Index n = joints();
  const double h = s - breaks[piece];
  const double* row = coefficients.data() + (piece + 1) * terms() * n;
  std::fill(q, q + n, 0.0);
  std::fill(first, first + n, 0.0);
  std::fill(second, second + n, 0.0);
  for (Index k = terms(); k > 0; --k) {
    row -= n;
    for (Index j = 0; j < n; ++j) {
      second[j] = second[j] * h + 2.0 * first[j];
      first[j] = first[j] * h + q[j];
      q[j] = q[j] * h + row[j];
    }
  }
}

}  // namespace leadthrough
