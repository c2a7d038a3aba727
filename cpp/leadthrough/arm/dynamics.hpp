#pragma once

// Torques (forces) of a chain's joints and its mass matrix, by KDL: recursive Newton-Euler and
// composite bodies, after Featherstone 2008. Only bodies of the chain have mass.

#include <memory>

#include "leadthrough/arm/chain.hpp"

namespace KDL {
class Chain;
class ChainIdSolver_RNE;
}  // namespace KDL

namespace leadthrough {

// Const and safe to use by several threads at once.
class Dynamics {
 public:
  explicit Dynamics(const Chain& chain);

  int joints() const { return chain_.joints(); }

  // q, qd, qdd: one configuration a row. gravity: m/s^2, base frame. One row of torques (N m, N)
  // each.
  Rows torques(const RowsRef& q, const RowsRef& qd, const RowsRef& qdd,
               const Eigen::Vector3d& gravity) const;

  // A row of the result holds a matrix (joints, joints).
  Rows mass_matrices(const RowsRef& q) const;

 private:
  friend class InverseDynamics;

  Chain chain_;
  std::shared_ptr<const KDL::Chain> bodies_;
};

// Torques of one configuration after the other, without allocating memory; for one thread.
class InverseDynamics {
 public:
  InverseDynamics(const Dynamics& dynamics, const Eigen::Vector3d& gravity);
  InverseDynamics(InverseDynamics&&) noexcept;
  ~InverseDynamics();

  // A value of each joint; the torques are written.
  void torques(const double* q, const double* qd, const double* qdd, double* torques);

 private:
  struct Room;

  Chain chain_;
  std::shared_ptr<const KDL::Chain> bodies_;
  std::unique_ptr<Room> room_;
};

}  // namespace leadthrough
