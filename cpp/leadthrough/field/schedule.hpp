#pragma once

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <vector>

#include "leadthrough/field/bucket_queue.hpp"
#include "leadthrough/field/padded_field.hpp"

namespace leadthrough {

// The cells of a front in buckets of time. A cell whose time falls is put into its new bucket; the
// entry in the old one is then stale and dropped when it is taken.
enum class MarchKind { kFresh, kRepair };  // a repair begins with times that are not queued

template <typename Real>
class Schedule {
 public:
  Schedule(std::vector<Real>& time, MarchKind kind)
      : time_(time), fresh_(kind == MarchKind::kFresh) {}

  // Adds a source, before the first refill. NaN, from squares that overflow, has no
  // bucket.
  void start(Cell cell, Real time) {
    if (!(time < time_[cell])) return;
    time_[cell] = time;
    queue_.push(BucketQueue::kOverflow, cell);
  }

  // Fills the buckets and goes to the first; false if no cell is left.
  bool refill();

  // Goes to the next bucket; false if it was the last.
  bool next() { return ++current_ < BucketQueue::kCount; }

  // Moves cells due in this bucket to `cells`, at most kChunk; returns how many, 0 at its end.
  int take(Cell* cells) {
    int due = 0;
    while (due == 0) {
      const int count = queue_.take(current_, cells);
      if (count == 0) return 0;
      for (int n = 0; n < count; ++n) {
        const Cell cell = cells[n];
        cells[due] = cell;
        due += is_due(time_[cell]) ? 1 : 0;
      }
    }
    return due;
  }

  // Lowers a cell's time, not below this bucket's.
  void improve(Cell cell, Real time) {
    const Real old = time_[cell];
    time_[cell] = time;
    const int target = bucket(time);
    const bool queued = fresh_ && old < std::numeric_limits<Real>::infinity() &&
                        target == bucket(old) && target != current_;
    if (!queued) queue_.push(target, cell);
  }

  // The time at which this bucket begins, but for rounding.
  Real begin() const { return base_ + static_cast<Real>(current_) / inverse_width_; }

  bool is_due(Real time) const { return bucket(time) == current_; }
  // At the end of a bucket: true if no cell can fall below this time any more.
  bool is_final(Real time) const { return bucket(time) <= current_; }

 private:
  // Half the quickest step between two cells: narrower buckets cost more scanning, wider ones more
  // repeated updates.
  static constexpr double kWidth = 0.5;

  int bucket(Real time) const {
    return static_cast<int>(
        std::min((time - base_) * inverse_width_, static_cast<Real>(BucketQueue::kOverflow)));
  }

  std::vector<Real>& time_;
  bool fresh_;
  BucketQueue queue_;
  Real base_ = 0;
  Real inverse_width_ = 0;
  int current_ = 0;
  std::vector<Cell> waiting_;
  std::vector<Cell> by_time_;
};

// Spreads the overflow over the buckets. They are made wider where a quarter of it would not fit
// otherwise: a slow region must not cost a sweep over empty buckets for every cell.
template <typename Real>
bool Schedule<Real>::refill() {
  const auto earlier = [this](Cell a, Cell b) { return time_[a] < time_[b]; };
  std::array<Cell, BucketQueue::kChunk> cells;
  waiting_.clear();
  const bool first = inverse_width_ == 0;
  while (const int count = queue_.take(BucketQueue::kOverflow, cells.data()))
    std::copy_if(cells.begin(), cells.begin() + count, std::back_inserter(waiting_),
                 [&](Cell cell) { return first || bucket(time_[cell]) == BucketQueue::kOverflow; });
  if (waiting_.empty()) return false;

  by_time_ = waiting_;
  const auto quarter = by_time_.begin() + static_cast<std::ptrdiff_t>(by_time_.size() / 4);
  std::nth_element(by_time_.begin(), quarter, by_time_.end(), earlier);
  base_ = time_[*std::min_element(by_time_.begin(), quarter + 1, earlier)];
  const Real span = time_[*quarter] - base_;
  inverse_width_ = std::min(Real(1 / kWidth), Real(BucketQueue::kCount - 1) / span);
  current_ = 0;
  for (const Cell cell : waiting_) queue_.push(bucket(time_[cell]), cell);
  return true;
}

}  // namespace leadthrough
