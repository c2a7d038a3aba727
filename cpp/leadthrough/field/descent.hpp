#pragma once

// The quickest path through a field of arrival times: down its gradient, from start to source.

#include <array>
#include <vector>

#include "leadthrough/field/cell_set.hpp"
#include "leadthrough/field/grid.hpp"

namespace leadthrough {

// Continuous index coordinates: whole numbers at the cells' centres. A point lies in the cell that
// its coordinates round to. In a 2D grid the first coordinate is 0.
using Coordinates = std::array<double, 3>;

enum class DescentStatus {
  kOk,
  kStartOutside,
  kStartUnreached,  // infinite arrival: a wall, or walled off
  kGoalNotSource,   // a neighbour of the goal's cell is earlier, or the goal is unreached
  kOtherSource,     // the descent ends in a cell that is not the goal's
  kTooManySteps,
  kNotTimes,  // NaN or a negative number near the point
};

// Name of a status in the bindings.
const char* name(DescentStatus status);

struct Descent {
  DescentStatus status;
  std::vector<Coordinates> path;  // from start to goal if the status is kOk
};

// Steps are at most `step` < 1 of the smallest spacing long. Every segment of the path stays in
// cells of finite arrival. Arrival falls from each point to the next; at corners too narrow for the
// gradient, the path passes centres of cells, each earlier than the last.
// Real is float or double.
template <typename Real>
Descent descend(const Grid& grid, const Real* arrival, const Coordinates& start,
                const Coordinates& goal, double step);

// The same for the times of a set of cells; all other cells count as unreached.
Descent descend(const CellSet& set, const double* arrival, const Coordinates& start,
                const Coordinates& goal, double step);

struct Direction {
  DescentStatus status;  // of the point as a start
  Coordinates unit;      // vector in space; 0 at a source's centre
};

// Direction of descent at a point. A step of half a cell or less along it meets no wall.
template <typename Real>
Direction direction(const Grid& grid, const Real* arrival, const Coordinates& p);

}  // namespace leadthrough
