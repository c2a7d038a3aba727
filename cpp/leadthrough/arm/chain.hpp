#pragma once

// Serial chains: the path of joints from a base link to a tip link, flattened so that every joint
// moves about or along its own z axis and fixed transforms are folded between them.

#include <array>
#include <initializer_list>
#include <string>
#include <variant>
#include <vector>

#include "leadthrough/arm/urdf.hpp"
#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

// Size of fixed workspaces; a chain with more moving joints is rejected.
constexpr int kMaxJoints = 16;

using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;  // no heap

// Drive of a moving joint: its value is multiplier * q[joint] + offset.
struct Drive {
  int joint = 0;
  double multiplier = 1.0;
  double offset = 0.0;
};

constexpr std::array<int, kMaxJoints> serial_frames() {
  std::array<int, kMaxJoints> frames{};
  for (std::size_t k = 0; k < frames.size(); ++k) frames[k] = static_cast<int>(k);
  return frames;
}

// T_base_tip = fixed[0] moving(0) fixed[1] moving(1) ... fixed[moving]. Each joint of the chain
// drives one moving joint, and more where some mimic it; without mimics the two are the same.
struct Chain {
  std::vector<std::string> joint_names;
  // Infinite where there is none; rad or m, per second, N m or N. Those of joints that mimic
  // narrow position and velocity of the joint that drives them.
  JointVector lower, upper, velocity, effort;
  // True if a full revolution of the joint leaves the arm's configuration unchanged.
  std::array<bool, kMaxJoints> periodic{};

  int moving = 0;
  bool mimics = false;
  std::array<bool, kMaxJoints> prismatic{};
  std::array<Drive, kMaxJoints> drives{};
  std::array<Transform, kMaxJoints + 1> fixed;
  // Frame in which each moving joint stands: 0 is the base, i + 1 moves with joint i. Collision
  // models alone have chains with more than one branch, see side_by_side.
  std::array<int, kMaxJoints> parent_frame = serial_frames();
  // The rigid body that a moving joint carries, loads included, in the joint's frame.
  std::array<urdf::Inertia, kMaxJoints> bodies;
  double mass = 0.0;  // of the bodies without loads, kg

  int joints() const { return static_cast<int>(joint_names.size()); }
};

// The chain from base down to tip. Links on branches count as bodies if they are fixed to the
// chain, but not if joints outside the chain move them. Errors: unknown links, a tip that does not
// descend from the base, joints that mimic one outside the chain, planar and floating joints, no
// joint at all, more than kMaxJoints.
std::variant<Chain, urdf::Error> make_chain(const urdf::Robot& robot, const std::string& base,
                                            const std::string& tip);

// The joints from base down to tip, fixed ones as well.
std::variant<std::vector<const urdf::Joint*>, urdf::Error> joints_between(const urdf::Robot& robot,
                                                                          const std::string& base,
                                                                          const std::string& tip);

// The chain with other limits of position; throws std::invalid_argument where they leave no value.
Chain with_bounds(const Chain& chain, const VectorRef& lower, const VectorRef& upper);
// The chain with another tip, given in the frame of the present one.
Chain with_tool(const Chain& chain, const Transform& T_tip_tool);
// The chain that carries a body, given in the frame of its tip.
Chain with_load(const Chain& chain, const urdf::Inertia& load);

// Bounds between which a joint is sampled: its limits, or where it has none one revolution, a metre
// to both sides.
struct JointRange {
  double lower, upper;
};
JointRange sampled_range(const Chain& chain, int joint);

// Upper bound on the tip's distance from the first joint, m.
double reach(const Chain& chain);

// Column i is the tip's velocity (linear first, base frame) for a unit velocity of joint i.
using JacobianColumns = std::array<Vector6, kMaxJoints>;

struct Kinematics {
  Transform T_base_tip;
  JacobianColumns jacobian;
};

// q: one value a joint, rad or m.
Transform forward_kinematics(const Chain& chain, const double* q);
void forward_kinematics(const Chain& chain, const double* q, Kinematics& kinematics);

// Positions and orientations (w, x, y, z), one row a configuration.
struct Poses {
  Rows3 positions;
  Rows4 orientations;
};
Poses forward_kinematics_batch(const Chain& chain, const RowsRef& q);

// Refuses configurations in rows that do not have one value a joint.
void check_rows(const Chain& chain, const RowsRef& q);
// The same of configurations with their rates, all of one size.
void check_rates(const Chain& chain, const RowsRef& q, std::initializer_list<RowsRef> rates);

}  // namespace leadthrough
