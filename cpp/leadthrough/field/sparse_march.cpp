#include "leadthrough/field/sparse_march.hpp"

#include <algorithm>
#include <array>

#include "leadthrough/field/sorted_march.hpp"

namespace leadthrough {

namespace {

// Times and steps of the cells of a set, like `PaddedField` for a whole grid. The set's missing
// cell, the last one, is a wall.
template <int D>
struct SparseField {
  const CellSet& set;
  std::array<double, D> spacing;  // relative to the smallest
  double unit;                    // the quickest step's time
  std::vector<double> time;
  std::vector<double> step;

  SparseField(const CellSet& cells, const double* speed)
      : set(cells),
        time(cells.size() + 1, kUnreached<double>),
        step(cells.size() + 1, kUnreached<double>) {
    const auto& distances = cells.grid().spacing;
    const double smallest = *std::min_element(distances.end() - D, distances.end());
    for (int axis = 0; axis < D; ++axis) spacing[axis] = distances[3 - D + axis] / smallest;
    const double fastest = *std::max_element(speed, speed + cells.size());
    unit = smallest / fastest;
    std::transform(speed, speed + cells.size(), step.begin(),
                   [&](double each) { return fastest / each; });
  }

  Index next(Index cell, int axis, int side) const {
    return set.next(static_cast<Cell>(cell), 3 - D + axis, side);
  }
};

template <int D>
std::vector<double> march_set(const CellSet& set, const double* speed,
                              const std::vector<Source>& sources, Index stop) {
  SparseField<D> field(set, speed);
  SortedMarch<double, D, SparseField<D>> march(field);
  for (const Source& source : sources) {
    const Cell place = set.find(source.cell);
    if (place != set.missing() && speed[place] > 0.0)
      march.start(place, source.time / field.unit, source.ball);
  }
  const Cell last = stop == kNoStop ? set.missing() : set.find(stop);
  march.run(last == set.missing() ? nullptr : &last);
  const double latest = field.time[last];
  std::vector<double> result(set.size());
  std::transform(field.time.begin(), field.time.end() - 1, result.begin(), [&](double time) {
    return time <= latest ? time * field.unit : kUnreached<double>;
  });
  return result;
}

}  // namespace

std::vector<double> march_second_order(const CellSet& set, const double* speed,
                                       const std::vector<Source>& sources, Index stop) {
  return set.grid().shape[0] == 1 ? march_set<2>(set, speed, sources, stop)
                                  : march_set<3>(set, speed, sources, stop);
}

}  // namespace leadthrough
