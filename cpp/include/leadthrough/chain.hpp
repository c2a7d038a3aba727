#pragma once

// Serial chains: the path of joints from a base link to a tip link, flattened so that every joint
// moves about or along its own z axis and fixed transforms are folded between them.

#include <Eigen/Core>
#include <array>
#include <string>
#include <variant>
#include <vector>

#include "leadthrough/urdf.hpp"

namespace KDL {
class Chain;
}

namespace leadthrough {

// Fixed-size workspaces: a chain with more joints is refused.
constexpr int kMaxJoints = 16;

using Vector6 = Eigen::Matrix<double, 6, 1>;
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;  // no heap

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Rows4 = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;

struct Pose {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d position;
};

// T_base_tip = fixed[0] joint(q0) fixed[1] joint(q1) ... fixed[n].
struct Chain {
  std::vector<std::string> joint_names;
  std::array<bool, kMaxJoints> prismatic{};
  std::array<urdf::Transform, kMaxJoints + 1> fixed;
  // Infinite where there is none; rad or m, per second, N m or N.
  JointVector lower, upper, velocity, effort;

  int joints() const { return static_cast<int>(joint_names.size()); }
};

// The chain from base down to tip. Refused: links that do not exist or do not lie in one line,
// joints that mimic, planar and floating joints, no joint at all, more than kMaxJoints.
std::variant<Chain, urdf::Error> make_chain(const urdf::Robot& robot, const std::string& base,
                                            const std::string& tip);

// The same chain for KDL, with inertias; needs <kdl/chain.hpp>. Throws std::invalid_argument where
// make_chain would return an error.
KDL::Chain make_kdl_chain(const urdf::Robot& robot, const std::string& base,
                          const std::string& tip);

// Column i of jacobian is the tip's velocity (linear first, base frame) for a unit velocity of
// joint i.
struct Kinematics {
  Pose T_base_tip;
  std::array<Vector6, kMaxJoints> jacobian;
};

// q: one value a joint, rad or m.
Pose forward_kinematics(const Chain& chain, const double* q);
void forward_kinematics(const Chain& chain, const double* q, Kinematics& kinematics);

// Positions and orientations (w, x, y, z), one row a configuration.
struct Poses {
  Rows3 positions;
  Rows4 orientations;
};
Poses forward_kinematics_batch(const Chain& chain, const Eigen::Ref<const Rows>& q);

}  // namespace leadthrough
