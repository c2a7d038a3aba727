#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "leadthrough/field/grid.hpp"

namespace leadthrough {

// A subset of a grid's cells in C order, each with its neighbours across faces. Work on it costs
// time linear in the set's size, independent of the grid's.
class CellSet {
 public:
  using Place = std::uint32_t;  // index of a cell in the set

  // Cells in the grid, ascending and each once.
  CellSet(const Grid& grid, std::vector<Index> cells);

  const Grid& grid() const { return grid_; }
  const std::vector<Index>& cells() const { return cells_; }
  std::size_t size() const { return cells_.size(); }

  // The index after the last represents every missing cell; its neighbours are missing too.
  Place missing() const { return static_cast<Place>(cells_.size()); }

  // axis: of the grid's three; side: -1 or 1.
  Place next(Place place, int axis, int side) const {
    return neighbours_[place][2 * axis + (side > 0 ? 1 : 0)];
  }

  // True if the grid has a further cell on that side.
  bool has_room(Place place, int axis, int side) const {
    const Index at = cells_[place] / strides_[axis] % grid_.shape[axis];
    return side > 0 ? at + 1 < grid_.shape[axis] : at > 0;
  }

  // True if a cell of finite time has a neighbour in the grid that the set lacks.
  bool is_open(const double* times) const;

  // `missing()` for a cell that is not in the set.
  Place find(Index cell) const;

 private:
  void join(int axis);

  Grid grid_;
  std::array<Index, 3> strides_;
  std::vector<Index> cells_;
  std::vector<std::array<Place, 6>> neighbours_;  // before and after along each axis
  Index first_row_ = 0;                           // of the rows along the last axis that hold cells
  std::vector<Place> row_begin_;                  // of each row from there on, and the end
};

// The cells of a grid whose centres lie within a radius of the centre of at least one of the given
// cells, which are ascending.
std::vector<Index> cells_within(const Grid& grid, const std::vector<Index>& cells, double radius);

// Coordinates of the centres of cells along the grid's three axes; the grid's first cell has its
// centre at `first`.
std::array<double, 3> centre_of(const Grid& grid, const std::array<double, 3>& first, Index cell);

// The children of cells of a grid half as fine: two along each axis of more than one cell. Both
// are ascending.
std::vector<Index> finer_cells(const Grid& coarse, const Grid& fine,
                               const std::vector<Index>& cells);

}  // namespace leadthrough
