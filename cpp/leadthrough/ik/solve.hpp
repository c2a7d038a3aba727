#pragma once

// Inverse kinematics of single poses: damped least squares with joint limits and restarts.
// The step is Nakamura and Hanafusa 1986's, with the damping led by the error as in
// Sugihara 2011; joints that reach a limit are held there and the others compensate.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "leadthrough/arm/chain.hpp"
#include "leadthrough/base/constants.hpp"

namespace leadthrough {

// Without a rotation only the position is constrained.
struct IkTarget {
  Eigen::Vector3d position;
  std::optional<Eigen::Matrix3d> rotation;
};

enum class IkStatus {
  kConverged,
  kUnreachable,  // beyond the arm's length, or converged away from the target
  kLimits,       // converged with joints pressed against their limits
  kBudget,       // iterations or CPU time used up
};

struct IkTolerance {
  double position = 1e-6;     // m
  double orientation = 1e-6;  // rad
};

// Requirements on each axis of the target's frame: along x, y, z, then about them. Without a
// rotation in the target the frame is the base's, and the last three are ignored.
struct IkAxes {
  std::array<bool, 6> free{};
  Vector6 tolerance = Vector6::Constant(kInfinity);  // m, rad
  Vector6 weight = Vector6::Ones();

  int asked(bool rotations) const {
    return static_cast<int>(std::count(free.begin(), free.begin() + (rotations ? 6 : 3), false));
  }
};

enum class IkMode {
  kFastest,  // the first solution found
  kClosest,  // of all solutions found within the budget, the one nearest to the reference
};

struct IkOptions {
  IkTolerance tolerance;
  std::optional<IkAxes> axes;  // none: all are constrained alike, which is quickest
  IkMode mode = IkMode::kFastest;
  std::optional<JointVector> reference;  // none: q0
  // Fraction of the distance to the middle of the joints' ranges taken by each step of self-motion
  // once the target is met, 0 (none) to 1; only redundant arms move.
  double nullspace_gain = 0.0;
  std::optional<JointVector> posture;  // self-motion goes here instead
  int max_iterations = 2000;
  int max_restarts = 100;
  double max_cpu_seconds = kInfinity;  // of this thread
  std::uint64_t seed = 0;              // of the restarts
};

struct IkResult {
  JointVector q;  // inside the limits, the closest one found
  IkStatus status = IkStatus::kBudget;
  double position_error = 0.0;     // m, over the constrained axes
  double orientation_error = 0.0;  // rad, 0 for targets without a rotation
  int iterations = 0;
  std::array<bool, kMaxJoints> limiting{};  // with kLimits, the joints whose limits block
};

struct ClosedForm;

// Here and below, arguments of another size than the chain's throw std::invalid_argument.
//
// A start q0 outside the limits is moved to the nearest configuration inside. `stream` selects an
// independent sequence of restarts. `form`, of this chain or null, finds the closest configuration
// and says why there is none.
IkResult solve_ik(const Chain& chain, const IkTarget& target, const VectorRef& q0,
                  const IkOptions& options = {}, std::uint64_t stream = 0,
                  const ClosedForm* form = nullptr);

enum class Restarts { kAlike, kEachItsOwn };

// One target a row, solved as by itself; orientations (w, x, y, z) may have no rows. If one pose
// stands in many rows, restarts of its own let each row look elsewhere. The results do not depend
// on the number of threads.
std::vector<IkResult> solve_ik_batch(const Chain& chain, const Rows3Ref& positions,
                                     const Rows4Ref& orientations, const RowsRef& starts,
                                     const IkOptions& options, int threads,
                                     const ClosedForm* form = nullptr,
                                     Restarts restarts = Restarts::kAlike);

struct IkSolutions {
  std::vector<IkResult> found;             // nearest to the reference first
  bool complete = false;                   // there are no others
  IkStatus status = IkStatus::kConverged;  // of no solution, the reason
  // Of seven joints: distance, rad, of the values of the swept parameter; 0 without a sweep.
  double resolution = 0.0;
};

// Up to `count` solutions, of which any two differ by more than `separation` (rad, modulo 2 pi, or
// m) in some joint; 0 is 0.1 for a search, and all of a closed form's. For redundant arms each is
// first moved in the null space as near to the reference as the task allows. With a closed form of
// six joints for a whole pose they are all there; otherwise a search continues until its budget is
// used up, and may find no solution.
IkSolutions solve_ik_all(const Chain& chain, const IkTarget& target, const VectorRef& q0,
                         const IkOptions& options, int count, double separation,
                         const ClosedForm* form = nullptr);

// Refuses a reference or posture of another number of joints.
void check_options(const Chain& chain, const IkOptions& options, bool rotations);

// Nearest configuration inside the limits; the middle of each range, 0 without a range.
JointVector project(const Chain& chain, const VectorRef& q);
JointVector middle(const Chain& chain);

}  // namespace leadthrough
