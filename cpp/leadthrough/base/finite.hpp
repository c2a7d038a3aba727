#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace leadthrough {

// True if all numbers are finite: infinity and NaN have an exponent of ones alone.
inline bool all_finite(const double* values, std::size_t count) {
  constexpr std::uint64_t kExponent = 0x7ff0000000000000;
  std::uint64_t wrong = 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, values + i, sizeof bits);
    wrong |= static_cast<std::uint64_t>((bits & kExponent) == kExponent);
  }
  return wrong == 0;
}

}  // namespace leadthrough
