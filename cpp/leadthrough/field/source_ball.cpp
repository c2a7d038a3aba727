#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/field/eikonal.hpp"
#include "leadthrough/field/sparse_march.hpp"

namespace leadthrough {

namespace {

struct Offset {
  std::array<Index, 3> cells;
  double distance;
};

// All cells within `radius`, the nearest first.
std::vector<Offset> offsets_within(const Grid& grid, double radius) {
  std::array<Index, 3> reach{};
  for (int axis = 0; axis < 3; ++axis)
    reach[axis] = static_cast<Index>(
        std::min(radius / grid.spacing[axis], static_cast<double>(grid.shape[axis] - 1)));
  std::vector<Offset> offsets;
  for (Index x = -reach[0]; x <= reach[0]; ++x) {
    for (Index y = -reach[1]; y <= reach[1]; ++y) {
      for (Index z = -reach[2]; z <= reach[2]; ++z) {
        const double distance = std::hypot(static_cast<double>(x) * grid.spacing[0],
                                           static_cast<double>(y) * grid.spacing[1],
                                           static_cast<double>(z) * grid.spacing[2]);
        if (distance > 0.0 && distance <= radius) offsets.push_back({{x, y, z}, distance});
      }
    }
  }
  std::stable_sort(offsets.begin(), offsets.end(),
                   [](const Offset& a, const Offset& b) { return a.distance < b.distance; });
  return offsets;
}

constexpr Index kOutside = -1;

Index moved(const Grid& grid, Index cell, const std::array<Index, 3>& by) {
  const auto strides = grid.strides();
  Index result = cell;
  for (int axis = 0; axis < 3; ++axis) {
    const Index at = cell / strides[axis] % grid.shape[axis] + by[axis];
    if (at < 0 || at >= grid.shape[axis]) return kOutside;
    result += by[axis] * strides[axis];
  }
  return result;
}

// Adds a source and the ball about it. `speed_at` returns the speed of a cell, NaN if unknown, and
// `is_source` is true for cells of sources.
template <typename SpeedAt, typename IsSource>
void append_ball(const Grid& grid, const std::vector<Offset>& offsets, const Source& source,
                 Index ball, const SpeedAt& speed_at, const IsSource& is_source,
                 std::vector<Source>& result) {
  const auto own = speed_at(source.cell);
  double border = kInfinity;  // the ball ends before it
  for (const Offset& offset : offsets) {
    if (offset.distance >= border) break;
    const Index cell = moved(grid, source.cell, offset.cells);
    if (cell == kOutside) continue;
    if (!(speed_at(cell) == own)) border = offset.distance;
    if (is_source(cell)) border = std::min(border, 0.5 * offset.distance);
  }
  result.push_back({source.cell, source.time, ball});
  for (const Offset& offset : offsets) {
    if (offset.distance >= border) break;
    const Index cell = moved(grid, source.cell, offset.cells);
    if (cell != kOutside)
      result.push_back({cell, source.time + offset.distance / static_cast<double>(own), ball});
  }
}

std::vector<Offset> ball_offsets(const Grid& grid, double radius) {
  check_argument(radius >= 0.0 && radius <= kMaxSourceRadius,
                 "source_radius: expected 0 to kMaxSourceRadius");
  return offsets_within(grid, radius * *std::min_element(grid.spacing.begin(), grid.spacing.end()));
}

}  // namespace

template <typename Real>
std::vector<Source> with_balls(const Grid& grid, const Real* speed,
                               const std::vector<Source>& sources, double radius) {
  std::vector<bool> is_source(static_cast<std::size_t>(grid.size()), false);
  for (const Source& source : sources) is_source[source.cell] = true;
  const std::vector<Offset> offsets = ball_offsets(grid, radius);
  std::vector<Source> result;
  for (std::size_t n = 0; n < sources.size(); ++n)
    append_ball(
        grid, offsets, sources[n], static_cast<Index>(n), [&](Index cell) { return speed[cell]; },
        [&](Index cell) { return is_source[cell]; }, result);
  return result;
}

std::vector<Source> with_ball(const CellSet& set, const double* speed, const Source& source,
                              double radius) {
  const auto speed_at = [&](Index cell) {
    const CellSet::Place place = set.find(cell);
    return place == set.missing() ? std::nan("") : speed[place];
  };
  std::vector<Source> result;
  append_ball(
      set.grid(), ball_offsets(set.grid(), radius), source, 0, speed_at,
      [](Index) { return false; }, result);
  return result;
}

template std::vector<Source> with_balls(const Grid&, const float*, const std::vector<Source>&,
                                        double);
template std::vector<Source> with_balls(const Grid&, const double*, const std::vector<Source>&,
                                        double);

}  // namespace leadthrough
