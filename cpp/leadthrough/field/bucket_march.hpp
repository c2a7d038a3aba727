#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>

#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/field/padded_field.hpp"
#include "leadthrough/field/schedule.hpp"
#include "leadthrough/field/upwind.hpp"

namespace leadthrough {

// The march of first order on buckets. Cells may be taken from a bucket before their time is final;
// they are then improved and pushed again, so that the result is the discrete equation's solution
// for every bucket width.
template <typename Real, int D, bool Cubes>
class BucketMarch {
 public:
  explicit BucketMarch(PaddedField<Real, D>& field, MarchKind kind = MarchKind::kFresh)
      : field_(field), schedule_(field.time, kind) {}

  // No balls here: at first order no time of a ball can fall below the exact one, for distances are
  // convex and the scheme takes them from earlier cells.
  void start(Cell cell, Real time, Index /*ball*/ = kNoBall) { schedule_.start(cell, time); }

  // Runs until every time is final, or those up to the time of `stop`, if there is one.
  void run(const Cell* stop) {
    std::array<Cell, BucketQueue::kChunk> cells;
    while (schedule_.refill()) {
      do {
        while (const int count = schedule_.take(cells.data())) {
          check_interrupt();
          update(find_neighbours(cells.data(), count));
        }
        if (stop && schedule_.is_final(field_.time[*stop])) return;
      } while (schedule_.next());
    }
  }

 private:
  static constexpr int kLanes = 4;  // more would not stay in registers
  static constexpr int kCapacity = (BucketQueue::kChunk * 2 * D + kLanes - 1) / kLanes * kLanes;
  using Lanes = Eigen::Array<Real, kLanes, 1>;
  using Column = Eigen::Array<Real, kCapacity, 1>;

  int find_neighbours(const Cell* cells, int count);
  void update(int count);
  void gather(int count);
  void solve(int count);
  void improve(int count);

  PaddedField<Real, D>& field_;
  Schedule<Real> schedule_;
  // Cells to update, found in one chunk: first a lower bound of their new time, then that time.
  std::array<Cell, kCapacity> cells_{};
  Column reached_ = Column::Zero();
  std::array<Column, D> upwind_{};
  Column step_ = Column::Zero();
};

// A neighbour can only fall if it is later than the front. An opposite neighbour that is earlier
// rules that out as well, but is seldom there, and far away in memory.
template <typename Real, int D, bool Cubes>
int BucketMarch<Real, D, Cubes>::find_neighbours(const Cell* cells, int count) {
  const Real* time = field_.time.data();
  int found = 0;
  for (int n = 0; n < count; ++n) {
    const Cell cell = cells[n];
    const Real t = time[cell];
    for (int axis = 0; axis < D; ++axis) {
      for (const Index stride : {-field_.stride[axis], field_.stride[axis]}) {
        const Index neighbour = cell + stride;
        cells_[found] = static_cast<Cell>(neighbour);
        reached_[found] = t * kLater<Real>;
        found += static_cast<int>(time[neighbour] > t);
      }
    }
  }
  return found;
}

template <typename Real, int D, bool Cubes>
void BucketMarch<Real, D, Cubes>::update(int count) {
  gather(count);
  solve(count);
  improve(count);
}

template <typename Real, int D, bool Cubes>
void BucketMarch<Real, D, Cubes>::gather(int count) {
  const Real* time = field_.time.data();
  for (int n = 0; n < count; ++n) {
    const Real* at = time + cells_[n];
    step_[n] = field_.step[cells_[n]];
    for (int axis = 0; axis < D; ++axis) {
      const Index stride = field_.stride[axis];
      upwind_[axis][n] = std::min(at[-stride], at[stride]);
    }
  }
}

template <typename Real, int D, bool Cubes>
void BucketMarch<Real, D, Cubes>::solve(int count) {
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
}

// Half of the updates improve nothing, in no order that a processor could predict: those that do
// are moved to the front without a branch.
template <typename Real, int D, bool Cubes>
void BucketMarch<Real, D, Cubes>::improve(int count) {
  const Real* time = field_.time.data();
  int improved = 0;
  for (int n = 0; n < count; ++n) {
    const Cell cell = cells_[n];
    const Real reached = reached_[n];
    cells_[improved] = cell;
    reached_[improved] = reached;
    // A wall's solution may be anything, since it was computed with infinite numbers.
    improved +=
        static_cast<int>(reached < time[cell]) & static_cast<int>(step_[n] < kUnreached<Real>);
  }
  for (int n = 0; n < improved; ++n) {
    // Not so if the cell has been improved a moment ago, through another neighbour.
    if (reached_[n] < time[cells_[n]]) schedule_.improve(cells_[n], reached_[n]);
  }
}

}  // namespace leadthrough
