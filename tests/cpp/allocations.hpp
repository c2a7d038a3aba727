#pragma once

// Counts heap allocations of the whole test program.

#include <cstddef>

namespace leadthrough::test {

std::size_t allocations();

}  // namespace leadthrough::test
