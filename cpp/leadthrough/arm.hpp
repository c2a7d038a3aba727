#pragma once

// A robot arm in one object: kinematics, dynamics, inverse kinematics, paths and collision of a
// chain of a URDF. All members are const and may be called by several threads at once. Arguments of
// a wrong size throw std::invalid_argument, which names them; q holds one value a joint, rad or m.

#include <string>
#include <vector>

#include "leadthrough/arm/dynamics.hpp"
#include "leadthrough/collision/check.hpp"
#include "leadthrough/ik/tracking.hpp"

namespace leadthrough {

class Arm {
 public:
  using Joints = VectorRef;
  using Path = RowsRef;  // one configuration a row

  // urdf: the document. meshes: the convex parts of the robot's collision meshes, in their order.
  // Throws std::invalid_argument with the element at fault, as in "joint7: ...".
  Arm(const std::string& urdf, const std::string& base, const std::string& tip,
      const std::vector<MeshParts>& meshes = {});

  // Names and limits of the joints.
  const Chain& chain() const { return chain_; }
  const CollisionModel& collision_model() const { return model_; }
  bool within_limits(const Joints& q) const;

  Transform forward_kinematics(const Joints& q) const;
  // (6, joints), linear rows first, base frame.
  Eigen::MatrixXd jacobian(const Joints& q) const;
  // Torques, N m (N); gravity in the base frame, m/s^2.
  Eigen::VectorXd inverse_dynamics(const Joints& q, const Joints& qd, const Joints& qdd,
                                   const Eigen::Vector3d& gravity = {0.0, 0.0, -9.81}) const;
  Eigen::MatrixXd mass_matrix(const Joints& q) const;

  IkResult inverse_kinematics(const IkTarget& target, const Joints& q0,
                              const IkOptions& options = {}) const;
  // One configuration for each pose, without jumps, from q0 on; orientations (w, x, y, z) may have
  // no rows. Fewer rows than poses: the next one was missed.
  Track follow(const Rows3Ref& positions, const Rows4Ref& orientations, const Joints& q0,
               const TrackOptions& options = {}) const;

  // The arm against itself, and against obstacles; between rows the joints move straight.
  MotionReport check_itself(const Path& q, const MotionOptions& options = {}) const;
  MotionReport check(const Path& q, const std::vector<Shape>& obstacles,
                     const MotionOptions& options = {}) const;

 private:
  Arm(const urdf::Robot& robot, const std::string& base, const std::string& tip,
      const std::vector<MeshParts>& meshes);

  Chain chain_;
  Dynamics dynamics_;
  CollisionModel model_;
  CollisionScene itself_;
};

}  // namespace leadthrough
