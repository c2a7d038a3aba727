#pragma once

// Inverse kinematics of single poses: damped least squares with joint limits and restarts.
// The step is Nakamura and Hanafusa 1986's, with the damping led by the error as in
// Sugihara 2011; joints that meet a limit are held there and the rest takes over their share.

#include <cstdint>
#include <optional>
#include <vector>

#include "leadthrough/chain.hpp"

namespace leadthrough {

// Without rotation only the position is asked for.
struct IkTarget {
  Eigen::Vector3d position;
  std::optional<Eigen::Matrix3d> rotation;
};

enum class IkStatus {
  kConverged,
  kUnreachable,  // beyond the arm's length
  kStalled,      // every attempt came to rest away from the target
  kBudget,       // iterations used up
};

struct IkTolerance {
  double position = 1e-6;     // m
  double orientation = 1e-6;  // rad
};

struct IkOptions {
  IkTolerance tolerance;
  // Share of the way to the middle of the joints' ranges taken by each step of self-motion once
  // the target is met, 0 (none) to 1; only redundant arms move.
  double midrange = 0.0;
  int max_iterations = 2000;
  int max_restarts = 100;
  std::uint64_t random_seed = 0;  // of the restarts
};

struct IkResult {
  JointVector q;  // inside the limits, the closest found
  IkStatus status = IkStatus::kBudget;
  double position_error = 0.0;     // m
  double orientation_error = 0.0;  // rad, 0 where no rotation was asked for
  int iterations = 0;
};

// A seed outside the limits is moved to the nearest configuration inside. `stream` selects an
// independent sequence of restarts.
IkResult solve_ik(const Chain& chain, const IkTarget& target,
                  const Eigen::Ref<const Eigen::VectorXd>& seed, const IkOptions& options = {},
                  std::uint64_t stream = 0);

// One target a row; orientations (w, x, y, z) may have no rows. The results do not depend on the
// number of threads.
std::vector<IkResult> solve_ik_batch(const Chain& chain, const Eigen::Ref<const Rows3>& positions,
                                     const Eigen::Ref<const Rows4>& orientations,
                                     const Eigen::Ref<const Rows>& seeds, const IkOptions& options,
                                     int threads);

// Nearest configuration inside the limits; the middle of each range, 0 where there is none.
JointVector project(const Chain& chain, const Eigen::Ref<const Eigen::VectorXd>& q);
JointVector middle(const Chain& chain);

}  // namespace leadthrough
