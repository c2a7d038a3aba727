#pragma once

// All configurations of an arm for a pose in closed form, by products of exponentials (Brockett
// 1984): e_1 e_2 ... e_n T_0 = T, each e_k a rotation about the k-th axis of the zero
// configuration. The structure is recognised from these axes, and not from names; arms close to it
// have it too.
//
// Six joints: axes 2, 3 and 4 are parallel, and 5 meets 6; or axes 4, 5 and 6 meet in a point
// (Pieper 1968); or either, counted from the tip. Seven joints: two groups of three meet (the angle
// of the elbow is given; Shimizu et al. 2008), or the six without the last joint, or without the
// first, are of those (the joint is given; He and Liu 2021).

#include <optional>

#include "leadthrough/ik/subproblems.hpp"
#include "leadthrough/ik/task.hpp"

namespace leadthrough {

// Axis of a joint: a unit direction through a point, base frame, zero configuration.
struct Screw {
  Eigen::Vector3d axis, point;
};

enum class Structure { kThreeParallel, kSphericalWrist, kTwoSpheres };
// Axes 1 to 3 of an arm with a spherical wrist.
enum class Shoulder { kParallel23, kMeeting12, kParallel12, kGeneral };
enum class Parameter { kNone, kFirstJoint, kLastJoint, kElbow };

struct ClosedForm {
  Structure structure = Structure::kSphericalWrist;
  Shoulder shoulder = Shoulder::kGeneral;
  Parameter parameter = Parameter::kNone;
  bool reversed = false;  // axes count from the tip, and angles are negative
  std::array<Screw, 7> screws;
  std::array<Eigen::Vector3d, 7> across;  // unit vectors perpendicular to the axes
  Eigen::Vector3d wrist;                  // where the last two or three axes meet
  Eigen::Vector3d meeting;                // of axes 1 and 2
  Screw given;                            // the joint that is a parameter
  Transform T_tip_base;                   // at zero
  double deviation = 0.0;                 // the arm's, from this structure, rad or m

  // But for rounding in floating point.
  bool exact() const { return deviation < 1e-12; }
  int joints() const { return parameter == Parameter::kNone ? 6 : 7; }
};

// None for other structures, other numbers of joints, prismatic and mimicking joints.
std::optional<ClosedForm> recognize(const Chain& chain);

struct Candidate {
  JointArray q{};  // -pi to pi
  int branch = 0;
  double missed = 0.0;  // as of the walk
};

struct Candidates {
  int count = 0;
  std::array<Candidate, 16> at;
};

// Configurations of the ideal arm, without limits. parameter: of arms that have one, rad.
void solve(const ClosedForm& form, const Transform& T_base_tip, double parameter, Walk& walk,
           Candidates& found);

}  // namespace leadthrough
