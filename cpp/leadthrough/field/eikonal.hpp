#pragma once

// Arrival times of a front that leaves its sources at time 0 and moves at a given speed: the
// eikonal equation |grad T| = 1 / speed by fast marching (Sethian 1996, "A fast marching level set
// method for monotonically advancing fronts"; second order: Sethian 1999, "Fast marching methods").

#include <vector>

#include "leadthrough/field/grid.hpp"

namespace leadthrough {

constexpr Index kNoBall = -1;

struct Source {
  Index cell;            // not a wall
  double time = 0.0;     // >= 0
  Index ball = kNoBall;  // sources of one ball do not reach one another: their times are exact
};

// The sources together with the cells around each, at their exact times: a difference scheme's
// error is largest beside a point source. A ball has at most `radius`, in the smallest spacing. It
// ends before the first cell of another speed, a wall included, and midway to the next source.
template <typename Real>
std::vector<Source> with_balls(const Grid& grid, const Real* speed,
                               const std::vector<Source>& sources, double radius);

constexpr Index kNoStop = -1;

// One time per cell, infinite if unreachable. A cell of speed 0 is a wall; the slowest other speed
// must be at least 1e-15 of the fastest. With a cell to stop at, cells that the front reaches later
// stay infinite.
// Real is float or double.
template <typename Real>
std::vector<Real> march_first_order(const Grid& grid, const Real* speed,
                                    const std::vector<Source>& sources, Index stop = kNoStop);
template <typename Real>
std::vector<Real> march_second_order(const Grid& grid, const Real* speed,
                                     const std::vector<Source>& sources, Index stop = kNoStop);

template <typename Real>
struct MarchProblem {
  const Real* speed;
  std::vector<Source> sources;
};

// Balls of exact times have millions of cells beyond this, in the smallest spacing.
constexpr double kMaxSourceRadius = 50.0;

struct MarchOptions {
  int order = 1;               // 1 or 2
  double source_radius = 0.0;  // of balls of exact times, in the smallest spacing
  Index stop = kNoStop;
};

template <typename Real>
std::vector<Real> march(const Grid& grid, const MarchProblem<Real>& problem,
                        const MarchOptions& options = {});

// The times of each problem, on up to `threads` threads; the bits do not depend on their number.
template <typename Real>
std::vector<std::vector<Real>> march_batch(const Grid& grid,
                                           const std::vector<MarchProblem<Real>>& problems,
                                           const MarchOptions& options, int threads);

}  // namespace leadthrough
