#include <Eigen/Core>
#include <array>
#include <cmath>

#include "lazy_heap.hpp"
#include "leadthrough/eikonal.hpp"
#include "padded_field.hpp"
#include "upwind.hpp"

namespace leadthrough {

namespace {

// The march of second order on a heap: its solution depends on the order in which cells become
// final, so that buckets would not do.
template <typename Real, int D>
class HeapMarch {
 public:
  explicit HeapMarch(PaddedField<Real, D>& field) : field_(field) {}

  void start(Cell cell, Real time) {
    if (time < field_.time[cell]) set(cell, time);
  }

  void run(const Cell* stop) {
    while (!heap_.empty()) {
      const LazyHeap::Entry entry = heap_.pop();
      const Real t = field_.time[entry.cell];
      if (entry.time != static_cast<float>(t)) continue;  // improved since
      if (stop && entry.cell == *stop) return;
      advance(entry.cell, t);
    }
  }

 private:
  void set(Cell cell, Real time) {
    field_.time[cell] = time;
    heap_.push(static_cast<float>(time), cell);
  }

  void advance(Cell cell, Real t) {
    for (int axis = 0; axis < D; ++axis) {
      for (const Index stride : {-field_.stride[axis], field_.stride[axis]}) {
        const Index neighbour = cell + stride;
        const Real old = field_.time[neighbour];
        if (!(old > t) || field_.step[neighbour] == kInfinity<Real>) continue;
        const Real time = std::max(t * kLater<Real>, solve(neighbour, t));
        if (time < old) set(static_cast<Cell>(neighbour), time);
      }
    }
  }

  // The time of a cell by its neighbours that are final, those not later than t. Sethian 1999: an
  // axis with two final cells in a row, the farther one not later, has the one-sided difference of
  // second order, 3/2 (T - (4 T1 - T2) / 3) / spacing.
  Real solve(Index cell, Real t) const {
    std::array<Real, D> nearest{};
    Real least = kInfinity<Real>, latest = 0;
    for (int axis = 0; axis < D; ++axis) {
      const Real* at = &field_.time[cell];
      const Index stride = field_.stride[axis];
      nearest[axis] = std::min(at[-stride], at[stride]);
      if (nearest[axis] > t) nearest[axis] = kInfinity<Real>;
      least = std::min(least, nearest[axis]);
    }
    Real weights = 0, first = 0, second = 0;  // sums of weight, weight * value, weight * value^2
    for (int axis = 0; axis < D; ++axis) {
      if (nearest[axis] == kInfinity<Real>) continue;
      latest = std::max(latest, nearest[axis]);
      Real weight = 1 / (field_.spacing[axis] * field_.spacing[axis]);
      Real value = nearest[axis] - least;
      const Real beyond = second_neighbour(cell, axis);
      if (beyond <= nearest[axis]) {
        value += (nearest[axis] - beyond) / 3;
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
    const Real* at = &field_.time[cell];
    const Index stride = field_.stride[axis];
    return at[-stride] < at[stride] ? at[-2 * stride] : at[2 * stride];
  }

  Real solve_first_order(const std::array<Real, D>& nearest, Real step) const {
    using One = Eigen::Array<Real, 1, 1>;
    std::array<One, D> upwind;
    for (int axis = 0; axis < D; ++axis) upwind[axis][0] = nearest[axis];
    return solve_boxes(upwind, field_.spacing, One::Constant(step).eval())[0];
  }

  PaddedField<Real, D>& field_;
  LazyHeap heap_;
};

template <typename Real, int D>
std::vector<Real> second_order(const Grid& grid, const Real* speed,
                               const std::vector<Source>& sources, Index stop) {
  PaddedField<Real, D> field(grid, speed);
  return run_march<HeapMarch<Real, D>>(field, sources, stop);
}

}  // namespace

template <typename Real>
std::vector<Real> march_second_order(const Grid& grid, const Real* speed,
                                     const std::vector<Source>& sources, Index stop) {
  return grid.shape[0] == 1 ? second_order<Real, 2>(grid, speed, sources, stop)
                            : second_order<Real, 3>(grid, speed, sources, stop);
}

template std::vector<float> march_second_order(const Grid&, const float*,
                                               const std::vector<Source>&, Index);
template std::vector<double> march_second_order(const Grid&, const double*,
                                                const std::vector<Source>&, Index);

}  // namespace leadthrough
