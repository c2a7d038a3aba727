#pragma once

#include <cstddef>

namespace leadthrough {

// Horner's scheme, coefficients in ascending order, for a number or an array of numbers.
template <typename Number, std::size_t size>
Number polynomial(const double (&coefficients)[size], const Number& x) {
  Number result = coefficients[size - 1] * x + coefficients[size - 2];
  for (std::size_t power = size - 2; power-- > 0;) result = result * x + coefficients[power];
  return result;
}

}  // namespace leadthrough
