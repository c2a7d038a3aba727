#pragma once

// Inverse kinematics along a path: every sample starts from the one before and may move each
// joint by a bounded step, so that the arm never jumps. The step is a regularised least-squares
// problem in a box, solved by an active set, and is accepted only if the error falls.

#include "leadthrough/ik/solve.hpp"

namespace leadthrough {

struct TrackOptions {
  // Tolerance of a solved sample; most samples come far closer.
  IkTolerance tolerance{1e-5, 1e-5};
  int max_iterations = 60;     // a sample
  double max_step = 0.5;       // the most a joint moves between two samples, rad or m
  std::optional<IkAxes> axes;  // none: all are constrained alike, which is quickest
};

// Up to and including the first sample that was missed.
struct Track {
  Rows q;  // one row a sample, inside the limits
  Eigen::VectorXd position_errors;
  Eigen::VectorXd orientation_errors;

  void keep(Eigen::Index samples);
};

// Null-space targets of a redundant arm, one row a sample. postures: joints without a preference
// are not finite. shares: fractions of the distance to the posture, from the previous sample.
struct Pull {
  RowsRef postures;
  VectorRef shares;
};

// Refuses arguments whose sizes differ from those of a path's samples or the chain.
void check_path(Eigen::Index samples, const Rows4Ref& orientations, const Pull& pull,
                const Chain& chain);

// The path alone, no time. positions: one row a sample; orientations (w, x, y, z) may have no
// rows. start: the configuration before the first sample.
Track track(const Chain& chain, const Rows3Ref& positions, const Rows4Ref& orientations,
            const VectorRef& start, const Pull& pull, const TrackOptions& options = {});

// A path with times, s.
struct TimedPath {
  VectorRef times;
  Rows3Ref positions;
  Rows4Ref orientations;
};

struct PursuitOptions {
  Eigen::VectorXd velocity, acceleration;  // limits of each joint, infinite if unlimited
  // Squared length, m^2, that weighs a joint's step (rad at 1 m) against the tip's error: the more,
  // the earlier the arm leaves the path beside a singularity, and the more gently.
  double damping = 0.0;
  IkTolerance deviation{1e-5, 1e-5};  // a sample with a larger error is missed
};

// The path at its own times, with joints inside their velocity and acceleration limits and always
// able to brake before their position limits; if this prevents tracking, the tip lags and catches
// up. The arm is at rest at `start` at the first time, and again at the last.
Track pursue(const Chain& chain, const TimedPath& path, const VectorRef& start, const Pull& pull,
             const PursuitOptions& options);

}  // namespace leadthrough
