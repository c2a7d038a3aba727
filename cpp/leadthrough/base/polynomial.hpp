#pragma once

#include <cstddef>

namespace leadthrough {

// Horner's scheme with the first `terms` coefficients in ascending order, for a number or an array
// of numbers.
template <std::size_t terms, typename Number, std::size_t size>
Number polynomial(const double (&coefficients)[size], const Number& x) {
  static_assert(2 <= terms && terms <= size);
  Number result = coefficients[terms - 1] * x + coefficients[terms - 2];
  for (std::size_t power = terms - 2; power-- > 0;) result = result * x + coefficients[power];
  return result;
}

template <typename Number, std::size_t size>
Number polynomial(const double (&coefficients)[size], const Number& x) {
  return polynomial<size>(coefficients, x);
}

// Of cos(x) and sin(x) / x, in powers of x^2; all terms are exact to rounding up to pi / 4.
inline constexpr double kCosine[] = {1.0,
                                     -1.0 / 2.0,
                                     1.0 / 24.0,
                                     -1.0 / 720.0,
                                     1.0 / 40320.0,
                                     -1.0 / 3628800.0,
                                     1.0 / 479001600.0,
                                     -1.0 / 87178291200.0,
                                     1.0 / 20922789888000.0};
inline constexpr double kSinc[] = {1.0,
                                   -1.0 / 6.0,
                                   1.0 / 120.0,
                                   -1.0 / 5040.0,
                                   1.0 / 362880.0,
                                   -1.0 / 39916800.0,
                                   1.0 / 6227020800.0,
                                   -1.0 / 1307674368000.0};

}  // namespace leadthrough
