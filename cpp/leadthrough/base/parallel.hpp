#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

// Calls work(i) for each i below `count`, on up to `threads` threads, this one among them. The
// first exception stops the rest and is thrown here.
template <typename Work>
void for_each_index(std::size_t count, int threads, const Work& work) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex mutex;
  std::condition_variable ended;
  int running = 0;
  constexpr std::chrono::milliseconds kWait{20};  // between looks for an interrupt
  const auto stopping_on_failure = [&](const auto& act) {
    try {
      act();
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      if (!failure) failure = std::current_exception();
      next = count;
    }
  };
  const auto run = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      check_interrupt();
      work(i);
    }
  };
  const auto help = [&, call = interrupt_watch.call] {
    interrupt_watch.call = call;
    stopping_on_failure(run);
    const std::lock_guard<std::mutex> lock(mutex);
    --running;
    ended.notify_one();
  };
  std::vector<std::thread> helpers;
  std::unique_lock<std::mutex> lock(mutex);
  try {
    for (int n = 1; n < threads && static_cast<std::size_t>(n) < count; ++n) {
      helpers.emplace_back(help);
      ++running;
    }
  } catch (const std::system_error&) {
    // The system has no more threads: the existing ones do the work.
  } catch (const std::bad_alloc&) {
    // Nor memory for them.
  }
  lock.unlock();
  stopping_on_failure(run);
  lock.lock();
  while (running > 0) {
    ended.wait_for(lock, kWait);
    lock.unlock();
    stopping_on_failure(look_for_interrupt);
    lock.lock();
  }
  lock.unlock();
  for (std::thread& helper : helpers) helper.join();
  if (failure) std::rethrow_exception(failure);
}

// Calls work(first, end) for blocks of `size` rows that a thread takes at a time.
template <typename Work>
void for_each_block(std::ptrdiff_t rows, std::ptrdiff_t size, int threads, const Work& work) {
  for_each_index(static_cast<std::size_t>((rows + size - 1) / size), threads,
                 [&](std::size_t block) {
                   const auto first = static_cast<std::ptrdiff_t>(block) * size;
                   work(first, std::min(first + size, rows));
                 });
}

}  // namespace leadthrough
