#include "base/allocations.hpp"

#include <atomic>
#include <cstdlib>

namespace {
std::atomic<std::size_t> count{0};
thread_local int left_of_thread = -1;  // no bound
}  // namespace

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// glibc lets a program put its own malloc before the library's.
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) noexcept {
  ++count;
  if (left_of_thread == 0) return nullptr;
  if (left_of_thread > 0) --left_of_thread;
  return __libc_malloc(size);
}
#endif

namespace leadthrough::test {

std::size_t allocations() { return count; }

NoMemory::NoMemory(int left) { left_of_thread = left; }
NoMemory::~NoMemory() { left_of_thread = -1; }

}  // namespace leadthrough::test
