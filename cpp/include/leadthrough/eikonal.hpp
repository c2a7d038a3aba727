#pragma once

// Arrival times of a front that leaves its sources at time 0 and moves at a given speed: the
// eikonal equation |grad T| = 1 / speed by fast marching (Sethian 1996, "A fast marching level set
// method for monotonically advancing fronts"; second order: Sethian 1999, "Fast marching methods").

#include <vector>

#include "leadthrough/grid.hpp"

namespace leadthrough {

struct Source {
  Index cell;         // not a wall
  double time = 0.0;  // >= 0
};

constexpr Index kNoStop = -1;

// One time a cell, infinite where the front does not come. A cell of speed 0 is a wall; the
// slowest other speed must not be below 1e-15 of the fastest. With a cell to stop at, cells that
// the front reaches later than it stay infinite.
// Real is float or double.
template <typename Real>
std::vector<Real> march_first_order(const Grid& grid, const Real* speed,
                                    const std::vector<Source>& sources, Index stop = kNoStop);
template <typename Real>
std::vector<Real> march_second_order(const Grid& grid, const Real* speed,
                                     const std::vector<Source>& sources, Index stop = kNoStop);

}  // namespace leadthrough
