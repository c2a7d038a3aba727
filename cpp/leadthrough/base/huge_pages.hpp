#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "leadthrough/base/interrupt.hpp"

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace leadthrough {

// Requests pages of 2 MiB if the system has them: random access then costs fewer page look-ups and
// fewer page faults. Small memory stays as it is, and so does memory whose request is refused; no
// result depends on it.
inline void ask_for_huge_pages([[maybe_unused]] const void* memory,
                               [[maybe_unused]] std::size_t bytes) {
#ifdef __linux__
  constexpr std::size_t kMin = std::size_t{4} << 20;  // holds a huge page at any alignment
  constexpr std::uintptr_t kPage = 4096;              // of most processors; others refuse
  if (bytes < kMin) return;
  const auto begin = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t first = (begin + kPage - 1) / kPage * kPage;
  madvise(reinterpret_cast<void*>(first), begin + bytes - first, MADV_HUGEPAGE);
#endif
}

// `count` times the value, in huge pages if they are many.
template <typename Value>
std::vector<Value> in_huge_pages(std::size_t count, Value value) {
  std::vector<Value> values;
  values.reserve(count);
  ask_for_huge_pages(values.data(), count * sizeof(Value));  // before its first page fault
  constexpr std::size_t kPart = std::size_t{1} << 20;
  while (values.size() < count) {
    look_for_interrupt();  // the system may take long to find pages
    values.resize(std::min(values.size() + kPart, count), value);
  }
  return values;
}

}  // namespace leadthrough
