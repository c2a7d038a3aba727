#include "leadthrough/eikonal.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "bucket_queue.hpp"
#include "padded_field.hpp"
#include "upwind.hpp"

namespace leadthrough {

namespace {

// Buckets as wide as half the quickest step between two cells: narrower ones cost more scanning,
// wider ones more cells that are improved after they were taken.
constexpr double kBucketWidth = 0.5;

// The march of first order on buckets. Cells may be taken from a bucket before their time is final;
// they are then improved and pushed again, so that the end is the discrete equation's solution
// whatever the buckets' width.
template <typename Real, int D, bool Cubes>
class BucketMarch {
 public:
  explicit BucketMarch(PaddedField<Real, D>& field) : field_(field) {}

  void start(Cell cell, Real time) {
    if (time >= field_.time[cell]) return;
    field_.time[cell] = time;
    queue_.push(BucketQueue::kOverflow, cell);
  }

  // Runs until every time is final, or those up to the time of `stop`, if there is one.
  void run(const Cell* stop) {
    while (refill()) {
      for (current_ = 0; current_ < BucketQueue::kCount; ++current_) {
        std::array<Cell, BucketQueue::kChunk> cells;
        while (const int count = queue_.take(current_, cells.data())) advance(cells.data(), count);
        if (stop && bucket(field_.time[*stop]) <= current_) return;
      }
    }
  }

 private:
  static constexpr int kLanes = 16;
  static constexpr int kCapacity = (BucketQueue::kChunk * 2 * D + kLanes - 1) / kLanes * kLanes;
  using Lanes = Eigen::Array<Real, kLanes, 1>;
  using Column = Eigen::Array<Real, kCapacity, 1>;

  int bucket(Real time) const {
    return static_cast<int>(
        std::min((time - base_) * inverse_width_, static_cast<Real>(BucketQueue::kOverflow)));
  }

  bool refill();
  void advance(const Cell* cells, int count);
  int find_neighbours(const Cell* cells, int count);
  void update(int count);

  PaddedField<Real, D>& field_;
  BucketQueue queue_;
  Real base_ = 0;
  Real inverse_width_ = 0;
  int current_ = 0;
  std::vector<Cell> waiting_;
  // Cells to update, found in one chunk: first a lower bound of their new time, then that time.
  std::array<Cell, kCapacity> cells_{};
  Column reached_ = Column::Zero();
  std::array<Column, D> upwind_{};
  Column step_ = Column::Zero();
};

// Spreads the overflow over the buckets. They are made wider where a quarter of it would not fit
// otherwise: a slow region must not cost a sweep over empty buckets for every cell.
template <typename Real, int D, bool Cubes>
bool BucketMarch<Real, D, Cubes>::refill() {
  const auto earlier = [this](Cell a, Cell b) { return field_.time[a] < field_.time[b]; };
  std::array<Cell, BucketQueue::kChunk> cells;
  waiting_.clear();
  while (const int count = queue_.take(BucketQueue::kOverflow, cells.data())) {
    for (int n = 0; n < count; ++n) {
      const bool stale = inverse_width_ > 0 && bucket(field_.time[cells[n]]) < BucketQueue::kCount;
      if (!stale) waiting_.push_back(cells[n]);
    }
  }
  if (waiting_.empty()) return false;
  base_ = field_.time[*std::min_element(waiting_.begin(), waiting_.end(), earlier)];
  std::vector<Cell> by_time = waiting_;
  const auto quarter = by_time.begin() + static_cast<std::ptrdiff_t>(by_time.size() / 4);
  std::nth_element(by_time.begin(), quarter, by_time.end(), earlier);
  const Real span = field_.time[*quarter] - base_;
  inverse_width_ = std::min(Real(1 / kBucketWidth), Real(BucketQueue::kCount - 1) / span);
  for (const Cell cell : waiting_) queue_.push(bucket(field_.time[cell]), cell);
  return true;
}

template <typename Real, int D, bool Cubes>
void BucketMarch<Real, D, Cubes>::advance(const Cell* cells, int count) {
  update(find_neighbours(cells, count));
}

// A neighbour can only fall if it is later than the front, and only through this cell if its
// opposite neighbour is not earlier (with "not later", cells between two equal ones would be lost).
template <typename Real, int D, bool Cubes>
int BucketMarch<Real, D, Cubes>::find_neighbours(const Cell* cells, int count) {
  const Real* time = field_.time.data();
  int found = 0;
  for (int n = 0; n < count; ++n) {
    const Cell cell = cells[n];
    const Real t = time[cell];
    if (bucket(t) != current_) continue;  // improved since, and done in an earlier bucket
    for (int axis = 0; axis < D; ++axis) {
      for (const Index stride : {-field_.stride[axis], field_.stride[axis]}) {
        const Index neighbour = cell + stride;
        cells_[found] = static_cast<Cell>(neighbour);
        reached_[found] = t * kLater<Real>;
        found +=
            static_cast<int>(time[neighbour] > t) & static_cast<int>(time[neighbour + stride] >= t);
      }
    }
  }
  return found;
}

template <typename Real, int D, bool Cubes>
void BucketMarch<Real, D, Cubes>::update(int count) {
  Real* time = field_.time.data();
  for (int n = 0; n < count; ++n) {
    const Real* at = time + cells_[n];
    step_[n] = field_.step[cells_[n]];
    for (int axis = 0; axis < D; ++axis) {
      const Index stride = field_.stride[axis];
      upwind_[axis][n] = std::min(at[-stride], at[stride]);
    }
  }
  for (int n = 0; n < count; n += kLanes) {
    std::array<Lanes, D> upwind;
    for (int axis = 0; axis < D; ++axis) upwind[axis] = upwind_[axis].template segment<kLanes>(n);
    const Lanes step = step_.template segment<kLanes>(n);
    // Never before the front: that bucket is behind us.
    auto reached = reached_.template segment<kLanes>(n);
    if constexpr (Cubes) {
      reached = solve_cubes(upwind, step).max(reached);
    } else {
      reached = solve_boxes(upwind, field_.spacing, step).max(reached);
    }
  }
  for (int n = 0; n < count; ++n) {
    const Cell cell = cells_[n];
    const Real old = time[cell];
    // A wall's solution may be anything, since it was computed with infinite numbers.
    if (!(reached_[n] < old && step_[n] < kInfinity<Real>)) continue;
    time[cell] = reached_[n];
    const int target = bucket(reached_[n]);
    const bool queued = old < kInfinity<Real> && target == bucket(old) && target != current_;
    if (!queued) queue_.push(target, cell);
  }
}

template <typename Real, int D>
std::vector<Real> first_order(const Grid& grid, const Real* speed,
                              const std::vector<Source>& sources, Index stop) {
  PaddedField<Real, D> field(grid, speed);
  const bool cubes = std::all_of(field.spacing.begin(), field.spacing.end(),
                                 [](Real spacing) { return spacing == Real(1); });
  return cubes ? run_march<BucketMarch<Real, D, true>>(field, sources, stop)
               : run_march<BucketMarch<Real, D, false>>(field, sources, stop);
}

}  // namespace

template <typename Real>
std::vector<Real> march_first_order(const Grid& grid, const Real* speed,
                                    const std::vector<Source>& sources, Index stop) {
  return grid.shape[0] == 1 ? first_order<Real, 2>(grid, speed, sources, stop)
                            : first_order<Real, 3>(grid, speed, sources, stop);
}

template std::vector<float> march_first_order(const Grid&, const float*, const std::vector<Source>&,
                                              Index);
template std::vector<double> march_first_order(const Grid&, const double*,
                                               const std::vector<Source>&, Index);

}  // namespace leadthrough
