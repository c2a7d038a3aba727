#pragma once

// The plain method of Yang et al., "DLS-IK and ProMPs", equations 3 to 7, as a baseline: one
// damped least-squares step per sample, with a pull to the middle of the ranges in the null space.
// solve_ik and track are quicker and reach more targets.

#include "leadthrough/ik/solve.hpp"

namespace leadthrough {

// The paper lets the damping grow with the condition number but states no rule. Ours is
// lambda^2 = damping^2 (1 - (condition_threshold / kappa)^2) above the threshold and 0 below: it
// starts smoothly and ends at `damping` in the singularity. kappa is the condition number of the
// Jacobian with its rotation rows in metres, and so are the task and the damping.
struct YangOptions {
  double damping = 0.1;  // m a rad
  double alpha = 0.0;    // of equation 5, (m a rad)^2
  double condition_threshold = 10.0;
  double nullspace_gain = 0.5;   // 1/s, rate of approach to the middle
  double rotation_weight = 0.3;  // m a rad
};

struct YangStep {
  JointVector velocity;
  double condition = 0.0;
  double damping = 0.0;  // lambda
};

// Equations 4 to 7. twist: the tool's velocity, linear first, base frame; its rotation is ignored
// with `positions_only`.
YangStep yang_step(const Chain& chain, const double* q, const Vector6& twist, bool positions_only,
                   const YangOptions& options = {});

// Steps of one second each towards a pose, clamped to the limits; no restarts.
IkResult solve_yang(const Chain& chain, const IkTarget& target, const VectorRef& q0,
                    const IkTolerance& tolerance, int max_iterations,
                    const YangOptions& options = {});

std::vector<IkResult> solve_yang_batch(const Chain& chain, const Rows3Ref& positions,
                                       const Rows4Ref& orientations, const RowsRef& starts,
                                       const IkTolerance& tolerance, int max_iterations,
                                       const YangOptions& options, int threads);

struct YangPath {
  Rows q;                              // one row a sample, inside the limits
  Eigen::VectorXd condition, damping;  // of the step to each sample
  Eigen::VectorXd position_errors, orientation_errors;
};

// One step per sample, from `start`; steps: seconds from the sample before. Orientations
// (w, x, y, z) may have no rows.
YangPath yang_path(const Chain& chain, const Rows3Ref& positions, const Rows4Ref& orientations,
                   const VectorRef& start, const VectorRef& steps, const YangOptions& options = {});

}  // namespace leadthrough
