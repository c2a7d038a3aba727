#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/field/eikonal.hpp"
#include "leadthrough/field/lazy_heap.hpp"
#include "leadthrough/field/padded_field.hpp"
#include "leadthrough/field/schedule.hpp"
#include "leadthrough/field/upwind.hpp"

namespace leadthrough {

// The march of second order. Its solution depends on the order in which cells become final: the
// cells of a bucket are sorted by a heap, which is far smaller than one for the whole front.
// Field is a PaddedField or a SparseField.
template <typename Real, int D, typename Field>
class SortedMarch {
 public:
  explicit SortedMarch(Field& field) : field_(field), schedule_(field.time, MarchKind::kFresh) {
    for (int axis = 0; axis < D; ++axis)
      weights_[axis] = 1 / (field.spacing[axis] * field.spacing[axis]);
  }

  void start(Cell cell, Real time, Index ball) {
    if (time >= field_.time[cell]) return;
    schedule_.start(cell, time);
    if (ball == kNoBall && ball_.empty()) return;
    if (ball_.empty()) ball_.assign(field_.time.size(), kNone);
    ball_[cell] = static_cast<std::int32_t>(ball);
  }

  // Runs until every time is final, or those up to the time of `stop`, if there is one.
  void run(const Cell* stop) {
    while (schedule_.refill()) {
      do {
        run_bucket();
        if (stop && schedule_.is_final(field_.time[*stop])) return;
      } while (schedule_.next());
    }
  }

 private:
  static constexpr std::int32_t kNone = kNoBall;

  void run_bucket() {
    std::array<Cell, BucketQueue::kChunk> cells;
    while (const int count = schedule_.take(cells.data()))
      for (int n = 0; n < count; ++n) heap_.push(key(field_.time[cells[n]]), cells[n]);
    for (unsigned turn = 0; !heap_.empty(); ++turn) {
      check_interrupt(turn);
      const LazyHeap::Entry entry = heap_.pop();
      const Real t = field_.time[entry.cell];
      if (entry.time == key(t)) advance(entry.cell, t);  // otherwise improved since
    }
  }

  // Times in the bucket begin at 0, so that a float tells them apart.
  float key(Real time) const {
    return static_cast<float>(std::max(time - schedule_.begin(), Real(0)));
  }

  bool are_exact(Cell a, Index b) const {
    return !ball_.empty() && ball_[a] != kNone && ball_[a] == ball_[b];
  }

  void set(Cell cell, Real time) {
    if (!ball_.empty()) ball_[cell] = kNone;
    if (schedule_.is_due(time)) {
      field_.time[cell] = time;
      heap_.push(key(time), cell);
    } else {
      schedule_.improve(cell, time);
    }
  }

  void advance(Cell cell, Real t) {
    for (int axis = 0; axis < D; ++axis) {
      for (const int side : {-1, 1}) {
        const Index neighbour = field_.next(cell, axis, side);
        const Real old = field_.time[neighbour];
        // The axis uses an earlier opposite neighbour instead of the cell.
        if (!(old > t) || field_.time[field_.next(neighbour, axis, side)] < t) continue;
        if (field_.step[neighbour] == kUnreached<Real>) continue;
        const Real time = std::max(t * kLater<Real>, solve(neighbour, t));
        if (time < old && !(old < kUnreached<Real> && are_exact(cell, neighbour)))
          set(static_cast<Cell>(neighbour), time);
      }
    }
  }

  // The time of a cell by its neighbours that are final, those not later than t. Sethian 1999: an
  // axis with two final cells in a row, the farther one not later, has the one-sided difference of
  // second order, 3/2 (T - (4 T1 - T2) / 3) / spacing.
  Real solve(Index cell, Real t) const {
    std::array<Real, D> nearest{};
    Real least = kUnreached<Real>, latest = 0;
    for (int axis = 0; axis < D; ++axis) {
      nearest[axis] = std::min(time_at(cell, axis, -1), time_at(cell, axis, 1));
      if (nearest[axis] > t) nearest[axis] = kUnreached<Real>;
      least = std::min(least, nearest[axis]);
    }
    Real weights = 0, first = 0, second = 0;  // sums of weight, weight * value, weight * value^2
    for (int axis = 0; axis < D; ++axis) {
      if (nearest[axis] == kUnreached<Real>) continue;
      latest = std::max(latest, nearest[axis]);
      Real weight = weights_[axis];
      Real value = nearest[axis] - least;
      const Real beyond = second_neighbour(cell, axis);
      if (beyond <= nearest[axis]) {
        value += (nearest[axis] - beyond) * Real(1.0 / 3.0);
        weight *= Real(9.0 / 4.0);
      }
      weights += weight;
      first += weight * value;
      second += weight * value * value;
    }
    const Real step = field_.step[cell];
    const Real discriminant = first * first - weights * (second - step * step);
    if (discriminant >= 0) {
      const Real time = least + (first + std::sqrt(discriminant)) / weights;
      if (time >= latest) return time;
    }
    return solve_first_order(nearest, step);  // these differences contradict each other
  }

  Real second_neighbour(Index cell, int axis) const {
    const int side = time_at(cell, axis, -1) < time_at(cell, axis, 1) ? -1 : 1;
    return time_at(field_.next(cell, axis, side), axis, side);
  }

  Real time_at(Index cell, int axis, int side) const {
    return field_.time[field_.next(cell, axis, side)];
  }

  Real solve_first_order(const std::array<Real, D>& nearest, Real step) const {
    using One = Eigen::Array<Real, 1, 1>;
    std::array<One, D> upwind;
    for (int axis = 0; axis < D; ++axis) upwind[axis][0] = nearest[axis];
    return solve_boxes(upwind, field_.spacing, One::Constant(step).eval())[0];
  }

  Field& field_;
  Schedule<Real> schedule_;
  std::array<Real, D> weights_{};
  LazyHeap heap_;
  std::vector<std::int32_t> ball_;  // of each cell that has the exact time of one
};

}  // namespace leadthrough
