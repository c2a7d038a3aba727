#pragma once

namespace leadthrough::test {

// Number of random cases of a test: all of them, or fewer with AddressSanitizer, which is slow
// and looks for faults of memory only: the build without it judges the answers of all.
constexpr int cases([[maybe_unused]] int all, [[maybe_unused]] int with_sanitizer) {
#ifdef __SANITIZE_ADDRESS__
  return with_sanitizer;
#else
  return all;
#endif
}

}  // namespace leadthrough::test
