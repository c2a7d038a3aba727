#pragma once

// The march of second order on a set of cells, for fronts that need only a band of a large grid.

#include <vector>

#include "leadthrough/field/cell_set.hpp"
#include "leadthrough/field/eikonal.hpp"

namespace leadthrough {

// The source together with the cells around it at their exact times, as in `with_balls`; the ball
// ends before the first cell outside the set.
std::vector<Source> with_ball(const CellSet& set, const double* speed, const Source& source,
                              double radius);

// One time and one speed per cell of the set. Cells outside it are walls, and sources in them are
// ignored. Cells later than the cell to stop at stay infinite.
std::vector<double> march_second_order(const CellSet& set, const double* speed,
                                       const std::vector<Source>& sources, Index stop = kNoStop);

}  // namespace leadthrough
