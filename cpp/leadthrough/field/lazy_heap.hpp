#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

namespace leadthrough {

// A 4-ary min-heap of cells by time. A cell whose time falls is pushed again and the stale entry
// stays; the caller drops it when it is popped. Key and cell share 64 bits: for times >= 0 the bits
// of a float sort as the float does.
class LazyHeap {
 public:
  struct Entry {
    float time;
    std::uint32_t cell;
  };

  bool empty() const { return entries_.empty(); }

  void push(float time, std::uint32_t cell) {
    const std::uint64_t entry = pack(time, cell);
    std::size_t hole = entries_.size();
    entries_.push_back(entry);
    while (hole > 0) {
      const std::size_t parent = (hole - 1) / 4;
      if (entries_[parent] <= entry) break;
      entries_[hole] = entries_[parent];
      hole = parent;
    }
    entries_[hole] = entry;
  }

  Entry pop() {
    const std::uint64_t top = entries_.front();
    const std::uint64_t last = entries_.back();
    entries_.pop_back();
    if (!entries_.empty()) sink(last);
    return unpack(top);
  }

 private:
  static std::uint64_t pack(float time, std::uint32_t cell) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &time, sizeof bits);
    return std::uint64_t{bits} << 32 | cell;
  }

  static Entry unpack(std::uint64_t entry) {
    const std::uint32_t bits = static_cast<std::uint32_t>(entry >> 32);
    Entry result{0.0f, static_cast<std::uint32_t>(entry)};
    std::memcpy(&result.time, &bits, sizeof bits);
    return result;
  }

  void sink(std::uint64_t entry) {
    const std::size_t size = entries_.size();
    std::size_t hole = 0;
    for (std::size_t child = 1; child < size; child = 4 * hole + 1) {
      std::size_t least = child;
      const std::size_t end = std::min(child + 4, size);
      for (std::size_t other = child + 1; other < end; ++other)
        if (entries_[other] < entries_[least]) least = other;
      if (entries_[least] >= entry) break;
      entries_[hole] = entries_[least];
      hole = least;
    }
    entries_[hole] = entry;
  }

  std::vector<std::uint64_t> entries_;
};

}  // namespace leadthrough
