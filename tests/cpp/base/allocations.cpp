#include "base/allocations.hpp"

#include <atomic>
#include <cstdlib>

namespace {
std::atomic<std::size_t> count{0};
}

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// glibc lets a program put its own malloc before the library's.
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) noexcept {
  ++count;
  return __libc_malloc(size);
}
#endif

std::size_t leadthrough::test::allocations() { return count; }
