#pragma once

// Counts the heap allocations of the whole test program, Eigen's as well.

#include <cstddef>

namespace leadthrough::test {

// 0 for ever where a sanitizer has its own malloc.
std::size_t allocations();

// While one lives, allocations of this thread fail, all but the first `left`.
class NoMemory {
 public:
  explicit NoMemory(int left);
  ~NoMemory();
  NoMemory(const NoMemory&) = delete;
  NoMemory& operator=(const NoMemory&) = delete;
};

}  // namespace leadthrough::test
