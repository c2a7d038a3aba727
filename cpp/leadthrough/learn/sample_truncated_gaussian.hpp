#pragma once

// Samples of a normal distribution truncated by linear inequalities.

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

// A Markov chain of standard normal vectors x with walls * x <= limits, by exact Hamiltonian Monte
// Carlo: from each draw on, a particle oscillates for a quarter of its period and is reflected by
// the walls. Pakman and Paninski 2014, "Exact Hamiltonian Monte Carlo for truncated multivariate
// Gaussians". walls: one per row, none of them zero. start: inside all walls. velocities: one row
// per draw, the particle's initial velocity, standard normal. The result has one row per draw.
Rows sample_truncated_gaussian(const RowsRef& walls, const VectorRef& limits,
                               const VectorRef& start, const RowsRef& velocities);

}  // namespace leadthrough
