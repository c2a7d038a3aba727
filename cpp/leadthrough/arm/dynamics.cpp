#include "leadthrough/arm/dynamics.hpp"

#include <algorithm>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#include <stdexcept>

#include "leadthrough/arm/rigid.hpp"
#include "leadthrough/arm/run_down.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

KDL::Vector to_kdl(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

KDL::Frame to_kdl(const Transform& transform) {
  const auto& r = transform.rotation;
  return {KDL::Rotation(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1),
                        r(2, 2)),
          to_kdl(transform.position)};
}

KDL::RigidBodyInertia to_kdl(const urdf::Inertia& inertia) {
  const auto& m = inertia.moments;
  return KDL::RigidBodyInertia(
      inertia.mass, to_kdl(inertia.center),
      KDL::RotationalInertia(m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)));
}

// One segment a moving joint; KDL has a segment's joint at its start and its body at its end.
KDL::Chain to_kdl(const Chain& chain) {
  KDL::Chain result;
  result.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::Fixed), to_kdl(chain.fixed[0])));
  for (std::size_t k = 0; k < moving_count(chain); ++k) {
    const KDL::Joint joint(chain.prismatic[k] ? KDL::Joint::TransZ : KDL::Joint::RotZ);
    result.addSegment(KDL::Segment(joint, to_kdl(chain.fixed[k + 1]),
                                   to_kdl(inverse(chain.fixed[k + 1]) * chain.bodies[k])));
  }
  return result;
}

// Only sizes that differ make KDL fail, and ours agree.
void require_success(int code) {
  if (code != KDL::SolverI::E_NOERROR) throw std::logic_error("KDL refused the chain");
}

KDL::JntArray joint_array(const Chain& chain) {
  return KDL::JntArray(static_cast<unsigned>(chain.moving));
}

void copy(const double* values, KDL::JntArray& joints) {
  std::copy_n(values, joints.data.size(), joints.data.data());
}

}  // namespace

Dynamics::Dynamics(const Chain& chain)
    : chain_(chain), bodies_(std::make_shared<const KDL::Chain>(to_kdl(chain))) {}

struct InverseDynamics::Room {
  KDL::ChainIdSolver_RNE solver;
  KDL::Wrenches none;
  KDL::JntArray values, rates, second_rates, forces;
  MovingValues moving;
};

InverseDynamics::InverseDynamics(const Dynamics& dynamics, const Eigen::Vector3d& gravity)
    : chain_(dynamics.chain_), bodies_(dynamics.bodies_) {
  const KDL::JntArray values = joint_array(chain_);
  room_.reset(new Room{KDL::ChainIdSolver_RNE(*bodies_, to_kdl(gravity)),
                       KDL::Wrenches(bodies_->getNrOfSegments(), KDL::Wrench::Zero()),
                       values,
                       values,
                       values,
                       values,
                       {}});
}

InverseDynamics::InverseDynamics(InverseDynamics&&) noexcept = default;
InverseDynamics::~InverseDynamics() = default;

void InverseDynamics::torques(const double* q, const double* qd, const double* qdd,
                              double* torques) {
  Room& room = *room_;
  copy(moving_values(chain_, q, room.moving), room.values);
  copy(moving_rates(chain_, qd, room.moving), room.rates);
  copy(moving_rates(chain_, qdd, room.moving), room.second_rates);
  require_success(
      room.solver.CartToJnt(room.values, room.rates, room.second_rates, room.none, room.forces));
  std::fill_n(torques, chain_.joints(), 0.0);
  for (std::size_t k = 0; k < moving_count(chain_); ++k)
    torques[chain_.drives[k].joint] +=
        chain_.drives[k].multiplier * room.forces(static_cast<unsigned>(k));
}

Rows Dynamics::torques(const RowsRef& q, const RowsRef& qd, const RowsRef& qdd,
                       const Eigen::Vector3d& gravity) const {
  check_rates(chain_, q, {qd, qdd});
  InverseDynamics solver(*this, gravity);
  Rows torques(q.rows(), chain_.joints());
  for (Eigen::Index row = 0; row < q.rows(); ++row) {
    check_interrupt(row);
    solver.torques(q.row(row).data(), qd.row(row).data(), qdd.row(row).data(),
                   torques.row(row).data());
  }
  return torques;
}

Rows Dynamics::mass_matrices(const RowsRef& q) const {
  check_rows(chain_, q);
  const Eigen::Index n = joints();
  KDL::ChainDynParam solver(*bodies_, KDL::Vector::Zero());
  KDL::JntArray values = joint_array(chain_);
  KDL::JntSpaceInertiaMatrix mass(static_cast<unsigned>(chain_.moving));
  MovingValues room;
  Rows matrices = Rows::Zero(q.rows(), n * n);
  for (Eigen::Index row = 0; row < q.rows(); ++row) {
    check_interrupt(row);
    copy(moving_values(chain_, q.row(row).data(), room), values);
    require_success(solver.JntToMass(values, mass));
    for (Eigen::Index k = 0; k < chain_.moving; ++k) {
      const Drive& a = chain_.drives[static_cast<std::size_t>(k)];
      for (Eigen::Index l = 0; l < chain_.moving; ++l) {
        const Drive& b = chain_.drives[static_cast<std::size_t>(l)];
        matrices(row, a.joint * n + b.joint) += a.multiplier * b.multiplier * mass.data(k, l);
      }
    }
  }
  return matrices;
}

}  // namespace leadthrough
