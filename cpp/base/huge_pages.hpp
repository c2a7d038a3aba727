#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace leadthrough {

// Asks for pages of 2 MiB where the system has them: memory that is read and written in no order
// then costs fewer look-ups of pages, and fewer are to be handed out. Small or refused, it stays as
// it is.
inline void ask_for_huge_pages([[maybe_unused]] const void* memory,
                               [[maybe_unused]] std::size_t bytes) {
#ifdef __linux__
  constexpr std::size_t kMin = std::size_t{4} << 20;  // has a huge page wherever it begins
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
  ask_for_huge_pages(values.data(), count * sizeof(Value));  // before a page of it is handed out
  values.resize(count, value);
  return values;
}

}  // namespace leadthrough
