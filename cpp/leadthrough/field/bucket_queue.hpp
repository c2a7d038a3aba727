#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace leadthrough {

// Cells sorted into buckets by time, first in first out inside a bucket.
//
// The buckets cover `kCount` times the width after a base time; later cells wait in one more
// bucket, the overflow. Cells are stored in recycled chunks, so that the memory in use is that of
// the front alone.
class BucketQueue {
 public:
  using Cell = std::uint32_t;

  static constexpr int kCount = 1024;
  static constexpr int kOverflow = kCount;
  static constexpr int kChunk = 62;  // a chunk then has 256 bytes

  BucketQueue() { buckets_.fill({kNone, kNone}); }

  void push(int bucket, Cell cell) {
    Bucket& target = buckets_[bucket];
    if (target.last == kNone || chunks_[target.last].count == kChunk) append_chunk(target);
    Chunk& chunk = chunks_[target.last];
    chunk.cells[chunk.count++] = cell;
  }

  // Moves the oldest cells of a bucket to `cells`, at most kChunk; returns how many.
  int take(int bucket, Cell* cells) {
    Bucket& source = buckets_[bucket];
    if (source.first == kNone) return 0;
    const std::uint32_t taken = source.first;
    Chunk& chunk = chunks_[taken];
    const int count = chunk.count;
    for (int n = 0; n < count; ++n) cells[n] = chunk.cells[n];
    source.first = chunk.next;
    if (source.first == kNone) source.last = kNone;
    chunk.next = free_;
    free_ = taken;
    return count;
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;

  struct Chunk {
    std::uint32_t next;
    std::int32_t count;
    std::array<Cell, kChunk> cells;
  };
  struct Bucket {
    std::uint32_t first;
    std::uint32_t last;
  };

  void append_chunk(Bucket& target) {
    std::uint32_t added = free_;
    if (added == kNone) {
      added = static_cast<std::uint32_t>(chunks_.size());
      chunks_.emplace_back();
    } else {
      free_ = chunks_[added].next;
    }
    chunks_[added].next = kNone;
    chunks_[added].count = 0;
    if (target.last == kNone) {
      target.first = added;
    } else {
      chunks_[target.last].next = added;
    }
    target.last = added;
  }

  std::array<Bucket, kCount + 1> buckets_;
  std::vector<Chunk> chunks_;
  std::uint32_t free_ = kNone;
};

}  // namespace leadthrough
