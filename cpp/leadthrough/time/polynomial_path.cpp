#include "leadthrough/time/polynomial_path.hpp"

#include <algorithm>
#include <array>

namespace leadthrough {

using Eigen::Index;

namespace {

// Horner's scheme with two derivatives, for a number of joints that is known when compiling: the
// loops unroll, and the sums stay in registers. `row` is behind the last coefficient.
template <std::size_t joints>
void evaluate(const double* row, Index terms, double h, double* q, double* first, double* second) {
  std::array<double, joints> sum{}, slope{}, bend{};
  for (Index k = terms; k > 0; --k) {
    row -= joints;
    for (std::size_t j = 0; j < joints; ++j) {
      bend[j] = bend[j] * h + 2.0 * slope[j];
      slope[j] = slope[j] * h + sum[j];
      sum[j] = sum[j] * h + row[j];
    }
  }
  std::copy(sum.begin(), sum.end(), q);
  std::copy(slope.begin(), slope.end(), first);
  std::copy(bend.begin(), bend.end(), second);
}

}  // namespace

Index PolynomialPath::piece_of(double s, Index piece) const {
  while (piece > 0 && s < breaks[piece]) --piece;
  while (piece + 1 < pieces() && s >= breaks[piece + 1]) ++piece;
  return piece;
}

void PolynomialPath::position(double s, Index piece, double* q, double* first,
                              double* second) const {
  const Index n = joints();
  const double h = s - breaks[piece];
  const Index count = terms();
  const double* row = coefficients.data() + (piece + 1) * count * n;
  if (n == 6) return evaluate<6>(row, count, h, q, first, second);
  if (n == 7) return evaluate<7>(row, count, h, q, first, second);
  std::fill(q, q + n, 0.0);
  std::fill(first, first + n, 0.0);
  std::fill(second, second + n, 0.0);
  for (Index k = count; k > 0; --k) {
    row -= n;
    for (Index j = 0; j < n; ++j) {
      second[j] = second[j] * h + 2.0 * first[j];
      first[j] = first[j] * h + q[j];
      q[j] = q[j] * h + row[j];
    }
  }
}

}  // namespace leadthrough
