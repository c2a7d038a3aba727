#pragma once

// Torques (forces) of a chain's joints and its mass matrix, by KDL: recursive Newton-Euler and
// composite bodies, after Featherstone 2008. Only bodies of the chain have mass.

#include "leadthrough/arm/chain.hpp"

namespace leadthrough {

// q, qd, qdd: one configuration a row. gravity: m/s^2, base frame. One row of torques (N m, N)
// each.
Rows inverse_dynamics_batch(const Chain& chain, const Eigen::Ref<const Rows>& q,
                            const Eigen::Ref<const Rows>& qd, const Eigen::Ref<const Rows>& qdd,
                            const Eigen::Vector3d& gravity);

// A row of the result holds a matrix (joints, joints).
Rows mass_matrix_batch(const Chain& chain, const Eigen::Ref<const Rows>& q);

}  // namespace leadthrough
