#pragma once

// Eight configurations at once, by the compiler's vectors. Only sums, products, comparisons and
// correctly rounded square roots: the same bits with any instruction set. Functions are inlined
// into callers that are compiled once for each set.

#include <cstdint>

namespace leadthrough::lanes {

constexpr int kCount = 8;
using Values = float __attribute__((vector_size(4 * kCount)));
using Flags = std::int32_t __attribute__((vector_size(4 * kCount)));  // -1 true, 0 false

[[gnu::always_inline]] inline void magnitude(Values& a) { a = a < 0.0F ? -a : a; }
[[gnu::always_inline]] inline void not_negative(Values& a) { a = a > 0.0F ? a : a * 0.0F; }
[[gnu::always_inline]] inline void root(Values& a) {
  for (int i = 0; i < kCount; ++i) a[i] = __builtin_sqrtf(a[i]);
}

[[gnu::always_inline]] inline bool all(const Flags& flags) {
  using Pairs = std::int64_t __attribute__((vector_size(4 * kCount)));
  const Pairs pairs = reinterpret_cast<Pairs>(flags);
  return (pairs[0] & pairs[1] & pairs[2] & pairs[3]) == -1;
}

// Bit i: flag i.
[[gnu::always_inline]] inline void to_bits(const Flags& flags, std::uint8_t& bits) {
  bits = 0;
  for (int i = 0; i < kCount; ++i) bits |= static_cast<std::uint8_t>((flags[i] & 1) << i);
}

// To 2e-7 for up to some hundred rad: reduced to a quarter turn, then the polynomials of Moshier's
// Cephes library.
[[gnu::always_inline]] inline void sine_and_cosine(const Values& angle, Values& sine,
                                                   Values& cosine) {
  constexpr float kRoundToInteger = 12582912.0F;  // 1.5 * 2^23
  const Values quarters = (angle * 0.636619772F + kRoundToInteger) - kRoundToInteger;
  Values x = angle - quarters * 1.5703125F;
  x = x - quarters * 4.837512969970703125e-4F;
  x = x - quarters * 7.54978995489188216e-8F;
  const Values z = x * x;
  const Values s = ((-1.9515295891e-4F * z + 8.3321608736e-3F) * z - 1.6666654611e-1F) * z * x + x;
  const Values c =
      ((2.443315711809948e-5F * z - 1.388731625493765e-3F) * z + 4.166664568298827e-2F) * z * z -
      0.5F * z + 1.0F;
  const Flags quadrant = __builtin_convertvector(quarters, Flags);
  const Flags swapped = (quadrant & 1) != 0;
  sine = swapped ? c : s;
  cosine = swapped ? s : c;
  sine = (quadrant & 2) != 0 ? -sine : sine;
  cosine = ((quadrant + 1) & 2) != 0 ? -cosine : cosine;
}

}  // namespace leadthrough::lanes
