#pragma once

// Draws from a normal distribution between walls.

#include "base/matrix.hpp"

namespace leadthrough {

// A Markov chain of standard normal vectors x with walls * x <= limits, by exact Hamiltonian Monte
// Carlo: from each draw on, a particle oscillates for a quarter of its period and bounces off the
// walls. Pakman and Paninski 2014, "Exact Hamiltonian Monte Carlo for truncated multivariate
// Gaussians". walls: a row a wall, none of them zero. start: inside all walls. velocities: a row a
// draw, the particle's first velocity, standard normal. The result has a row a draw.
Rows sample_truncated_gaussian(const Eigen::Ref<const Rows>& walls,
                               const Eigen::Ref<const Eigen::VectorXd>& limits,
                               const Eigen::Ref<const Eigen::VectorXd>& start,
                               const Eigen::Ref<const Rows>& velocities);

}  // namespace leadthrough
