#include "leadthrough/field/cell_set.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace leadthrough {

CellSet::CellSet(const Grid& grid, std::vector<Index> cells)
    : grid_(grid), strides_(grid.strides()), cells_(std::move(cells)) {
  const Place none = missing();
  neighbours_.assign(cells_.size() + 1, {none, none, none, none, none, none});
  for (int axis = 0; axis < 3; ++axis)
    if (grid.shape[axis] > 1) join(axis);
  if (cells_.empty()) return;
  const Index length = grid.shape[2];
  first_row_ = cells_.front() / length;
  row_begin_.reserve(static_cast<std::size_t>(cells_.back() / length - first_row_ + 2));
  for (Place place = 0; place < none; ++place)
    while (static_cast<Index>(row_begin_.size()) <= cells_[place] / length - first_row_)
      row_begin_.push_back(place);
  row_begin_.push_back(none);
}

// The neighbour of each cell is one stride further, hence the neighbours are in order too.
void CellSet::join(int axis) {
  const Index stride = strides_[axis];
  Place after = 0;
  for (Place place = 0; place < missing(); ++place) {
    if (!has_room(place, axis, 1)) continue;
    while (after < missing() && cells_[after] < cells_[place] + stride) ++after;
    if (after == missing()) return;
    if (cells_[after] != cells_[place] + stride) continue;
    neighbours_[place][2 * axis + 1] = after;
    neighbours_[after][2 * axis] = place;
  }
}

bool CellSet::is_open(const double* times) const {
  for (Place place = 0; place < missing(); ++place) {
    if (!std::isfinite(times[place])) continue;
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {-1, 1})
        if (next(place, axis, side) == missing() && has_room(place, axis, side)) return true;
  }
  return false;
}

CellSet::Place CellSet::find(Index cell) const {
  const Index row = cell / grid_.shape[2] - first_row_;
  if (row < 0 || row + 1 >= static_cast<Index>(row_begin_.size())) return missing();
  const auto begin = cells_.begin() + row_begin_[row], end = cells_.begin() + row_begin_[row + 1];
  const auto found = std::lower_bound(begin, end, cell);
  return found == end || *found != cell ? missing() : static_cast<Place>(found - cells_.begin());
}

namespace {

struct Run {  // cells of one row along the last axis
  Index row;
  Index first;
  Index last;
};

// Cells of a neighbouring row inside a ball about a cell.
struct Chord {
  Index x;
  Index y;
  Index half;
};

std::vector<Chord> chords_of(const Grid& grid, double radius) {
  const auto reach = [&](int axis) {
    const double most = static_cast<double>(grid.shape[axis] - 1);
    return static_cast<Index>(std::min(radius / grid.spacing[axis], most));
  };
  std::vector<Chord> chords;
  for (Index x = -reach(0); x <= reach(0); ++x) {
    for (Index y = -reach(1); y <= reach(1); ++y) {
      const double across = std::hypot(static_cast<double>(x) * grid.spacing[0],
                                       static_cast<double>(y) * grid.spacing[1]);
      Index half = reach(2);
      while (half >= 0 && std::hypot(across, static_cast<double>(half) * grid.spacing[2]) > radius)
        --half;
      if (half >= 0) chords.push_back({x, y, half});
    }
  }
  return chords;
}

std::vector<Run> runs_of(const Grid& grid, const std::vector<Index>& cells) {
  std::vector<Run> runs;
  for (const Index cell : cells) {
    const Index row = cell / grid.shape[2], at = cell % grid.shape[2];
    if (!runs.empty() && runs.back().row == row && runs.back().last + 1 == at)
      runs.back().last = at;
    else
      runs.push_back({row, at, at});
  }
  return runs;
}

}  // namespace

std::array<double, 3> centre_of(const Grid& grid, const std::array<double, 3>& first, Index cell) {
  const Index row = cell / grid.shape[2];
  const Index layer = row / grid.shape[1];
  const std::array<Index, 3> at{layer, row - layer * grid.shape[1], cell - row * grid.shape[2]};
  std::array<double, 3> centre;
  for (std::size_t axis = 0; axis < 3; ++axis)
    centre[axis] = static_cast<double>(at[axis]) * grid.spacing[axis] + first[axis];
  return centre;
}

std::vector<Index> cells_within(const Grid& grid, const std::vector<Index>& cells, double radius) {
  const std::vector<Chord> chords = chords_of(grid, radius);
  std::vector<Run> wide;
  for (const Run& run : runs_of(grid, cells)) {
    const Index x = run.row / grid.shape[1], y = run.row % grid.shape[1];
    for (const Chord& chord : chords) {
      const Index to_x = x + chord.x, to_y = y + chord.y;
      if (to_x < 0 || to_x >= grid.shape[0] || to_y < 0 || to_y >= grid.shape[1]) continue;
      wide.push_back({to_x * grid.shape[1] + to_y, std::max(run.first - chord.half, Index(0)),
                      std::min(run.last + chord.half, grid.shape[2] - 1)});
    }
  }
  std::sort(wide.begin(), wide.end(), [](const Run& a, const Run& b) {
    return a.row != b.row ? a.row < b.row : a.first < b.first;
  });
  std::vector<Index> result;
  Index end = 0;  // of the cells so far
  for (const Run& run : wide) {
    const Index start = run.row * grid.shape[2];
    for (Index cell = std::max(start + run.first, end); cell <= start + run.last; ++cell)
      result.push_back(cell);
    end = std::max(end, start + run.last + 1);
  }
  return result;
}

std::vector<Index> finer_cells(const Grid& coarse, const Grid& fine,
                               const std::vector<Index>& cells) {
  const auto strides = coarse.strides(), to = fine.strides();
  const auto children = [&](int axis, Index at) {
    if (fine.shape[axis] == 1) return std::pair<Index, Index>{0, 1};
    return std::pair<Index, Index>{2 * at, std::min(2 * at + 2, fine.shape[axis])};
  };
  const auto same = [&](std::size_t a, std::size_t b, int axis) {
    return cells[a] / strides[axis] == cells[b] / strides[axis];
  };
  std::vector<Index> result;
  result.reserve(8 * cells.size());
  for (std::size_t plane = 0, past = 0; plane < cells.size(); plane = past) {
    for (past = plane; past < cells.size() && same(plane, past, 0);) ++past;
    const auto [x, x_end] = children(0, cells[plane] / strides[0]);
    for (Index to_x = x; to_x < x_end; ++to_x) {
      for (std::size_t row = plane, end = plane; row < past; row = end) {
        for (end = row; end < past && same(row, end, 1);) ++end;
        const auto [y, y_end] = children(1, cells[row] / strides[1] % coarse.shape[1]);
        for (Index to_y = y; to_y < y_end; ++to_y) {
          for (std::size_t n = row; n < end; ++n) {
            const auto [z, z_end] = children(2, cells[n] % coarse.shape[2]);
            for (Index to_z = z; to_z < z_end; ++to_z)
              result.push_back(to_x * to[0] + to_y * to[1] + to_z);
          }
        }
      }
    }
  }
  return result;
}

}  // namespace leadthrough
