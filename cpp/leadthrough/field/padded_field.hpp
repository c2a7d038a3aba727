#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "leadthrough/base/huge_pages.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/field/eikonal.hpp"

namespace leadthrough {

using Cell = std::uint32_t;  // index in a padded field

template <typename Real>
constexpr Real kUnreached = std::numeric_limits<Real>::infinity();

// Times grow from cell to cell by at least this factor, even if a step is lost in rounding: a
// descent then exists from every reached cell.
template <typename Real>
constexpr Real kLater = 1 + 2 * std::numeric_limits<Real>::epsilon();

// Times and steps inside a border of infinite cells, in units of the quickest step between two
// cells, so that no speed or spacing overflows. D is 2 or 3.
template <typename Real, int D>
struct PaddedField {
  std::array<Index, D> stride;
  std::array<Real, D> spacing;  // relative to the smallest
  std::array<Index, 3> shape;   // of the grid without its border
  Index first = 0;              // of the grid's first cell
  double unit = 1.0;            // the quickest step's time
  std::vector<Real> time;
  std::vector<Real> step;  // time over a distance of 1; infinite in walls and in the border

  PaddedField(const Grid& grid, const Real* speed);

  Index row(Index x, Index y) const {
    return first + y * stride[D - 2] + (D == 3 ? x * stride[0] : 0);
  }
  Cell cell(Index index) const {
    const Index line = index / shape[2];
    return static_cast<Cell>(row(line / shape[1], line % shape[1]) + index % shape[2]);
  }
  Index next(Index cell, int axis, int side) const { return cell + side * stride[axis]; }
  bool has_cubes() const {
    return std::all_of(spacing.begin(), spacing.end(), [](Real h) { return h == Real(1); });
  }
  std::vector<Real> times_up_to(Real limit) const;
  // The same in the memory of `time`, which is empty then.
  std::vector<Real> take_times_up_to(Real limit);

 private:
  std::size_t grid_size() const { return static_cast<std::size_t>(shape[0] * shape[1] * shape[2]); }
  void copy_times_up_to(Real limit, Real* to) const;
};

template <typename Real, int D>
PaddedField<Real, D>::PaddedField(const Grid& grid, const Real* speed) : shape(grid.shape) {
  const double smallest = *std::min_element(grid.spacing.end() - D, grid.spacing.end());
  Index size = 1;
  for (int axis = D - 1; axis >= 0; --axis) {
    stride[axis] = size;
    first += size;
    size *= shape[3 - D + axis] + 2;
    spacing[axis] = static_cast<Real>(grid.spacing[3 - D + axis] / smallest);
  }
  // Neighbours of border cells are read as well: one more plane at either end.
  const Index margin = stride[0];
  first += margin;
  const auto cells = static_cast<std::size_t>(size + 2 * margin);
  if (cells > std::numeric_limits<Cell>::max())
    throw std::length_error("the grid has more cells than a march can number: 2^32");
  time = in_huge_pages(cells, kUnreached<Real>);
  step = in_huge_pages(cells, kUnreached<Real>);

  const Real fastest =
      Eigen::Map<const Eigen::Array<Real, Eigen::Dynamic, 1>>(speed, grid.size()).maxCoeff();
  unit = smallest / static_cast<double>(fastest);
  for (Index x = 0; x < shape[0]; ++x) {
    check_interrupt();
    for (Index y = 0; y < shape[1]; ++y) {
      Real* to = step.data() + row(x, y);
      for (Index z = 0; z < shape[2]; ++z) to[z] = fastest / *speed++;
    }
  }
}

template <typename Real, int D>
std::vector<Real> PaddedField<Real, D>::times_up_to(Real limit) const {
  std::vector<Real> result(grid_size());
  copy_times_up_to(limit, result.data());
  return result;
}

template <typename Real, int D>
std::vector<Real> PaddedField<Real, D>::take_times_up_to(Real limit) {
  copy_times_up_to(limit, time.data());  // every element is read before it is overwritten
  time.resize(grid_size());
  // A flat grid's border is larger than the grid.
  if (time.capacity() > time.size() + time.size() / 4) time.shrink_to_fit();
  return std::exchange(time, {});
}

template <typename Real, int D>
void PaddedField<Real, D>::copy_times_up_to(Real limit, Real* to) const {
  const Real scale = static_cast<Real>(unit);
  for (Index x = 0; x < shape[0]; ++x) {
    for (Index y = 0; y < shape[1]; ++y) {
      const Real* from = time.data() + row(x, y);
      for (Index z = 0; z < shape[2]; ++z)
        *to++ = from[z] <= limit ? from[z] * scale : kUnreached<Real>;
    }
  }
}

// Marches from the sources until every time is final, or all up to that of cell `stop`. The field
// has no times then.
template <typename March, typename Real, int D>
std::vector<Real> run_march(PaddedField<Real, D>& field, const std::vector<Source>& sources,
                            Index stop) {
  March march(field);
  for (const Source& source : sources)
    march.start(field.cell(source.cell), static_cast<Real>(source.time / field.unit), source.ball);
  if (stop == kNoStop) {
    march.run(nullptr);
    return field.take_times_up_to(kUnreached<Real>);
  }
  const Cell last = field.cell(stop);
  march.run(&last);
  return field.take_times_up_to(field.time[last]);
}

}  // namespace leadthrough
