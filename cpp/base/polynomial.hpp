#pragma once

#include <cstddef>

namespace leadthrough {

// By Horner's scheme, the coefficients in rising order; of a number, or of several in an array.
template <typename Number, std::size_t size>
Number polynomial(const double (&coefficients)[size], const Number& x) {
  Number result = coefficients[size - 1] * x + coefficients[size - 2];
  for (std::size_t power = size - 2; power-- > 0;) result = result * x + coefficients[power];
  return result;
}

}  // namespace leadthrough
