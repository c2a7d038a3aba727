#pragma once

// One pass down the levels of a stack.

#include "leadthrough/ik/polytope.hpp"
#include "leadthrough/ik/task_priority.hpp"

namespace leadthrough {

// At most the joints' bounds and one row a unilateral level.
constexpr int kMaxUnilateral = 48;

class PriorityPass {
 public:
  // Starts from the motion inside the box that is nearest to rest.
  PriorityPass(const MotionBox& box, double quickness);

  // Comes as near to jacobian * motion = wanted as the levels before and the bounds allow, and
  // constrains later levels to preserve it. True if a bound is active.
  bool equal(const TaskMatrix& jacobian, const JointVector& wanted);
  // The same for jacobian * motion >= wanted, one row.
  bool at_least(const TaskMatrix& jacobian, double wanted);

  const JointVector& motion() const { return motion_; }

 private:
  using Basis = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxJoints,
                              kMaxJoints>;
  using Polytope = leadthrough::Polytope<kMaxJoints + kMaxUnilateral, kMaxJoints>;
  // A change of the motion along `basis`: the least sum of weight * (coordinate - pull / weight)^2.
  struct Step {
    Basis basis;
    JointVector pull, weight;
    Eigen::Index rank = 0;  // number of leading coordinates in the level's range
  };

  Step plan(const TaskMatrix& jacobian, const JointVector& wanted) const;
  bool move(const Step& step);
  static JointVector nearest(const Step& step, double damping, Polytope::Rows rows,
                             const Polytope::Sides& lower, const Polytope::Sides& upper);

  MotionBox box_;
  double quickness_;
  JointVector motion_;
  Basis free_;  // orthonormal columns
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMaxUnilateral, kMaxJoints>
      rows_;  // of the unilateral levels so far
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxUnilateral, 1> bounds_;
};

}  // namespace leadthrough
