#pragma once

// Counts the heap allocations of the whole test program, Eigen's as well.

#include <cstddef>

namespace leadthrough::test {

// 0 for ever where a sanitizer has its own malloc.
std::size_t allocations();

}  // namespace leadthrough::test
