#pragma once

// Torques (forces) of a chain's joints and its mass matrix, by KDL: recursive Newton-Euler and
// composite bodies, after Featherstone 2008. Only bodies of the chain have mass.

#include <memory>

#include "leadthrough/arm/chain.hpp"

namespace KDL {
class Chain;
}

namespace leadthrough {

// Const and safe to use by several threads at once.
class Dynamics {
 public:
  explicit Dynamics(const Chain& chain);

  int joints() const { return chain_.joints(); }

  // q, qd, qdd: one configuration a row. gravity: m/s^2, base frame. One row of torques (N m, N)
  // each.
  Rows torques(const Eigen::Ref<const Rows>& q, const Eigen::Ref<const Rows>& qd,
               const Eigen::Ref<const Rows>& qdd, const Eigen::Vector3d& gravity) const;

  // A row of the result holds a matrix (joints, joints).
  Rows mass_matrices(const Eigen::Ref<const Rows>& q) const;

 private:
  Chain chain_;
  std::shared_ptr<const KDL::Chain> bodies_;
};

}  // namespace leadthrough
