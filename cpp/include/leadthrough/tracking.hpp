#pragma once

// Inverse kinematics along a path: every sample starts from the one before and may move each
// joint by a bounded step, so that the arm never jumps. The step is a regularised least-squares
// problem in a box, solved by an active set, and is taken only when the error falls.

#include <vector>

#include "leadthrough/ik.hpp"

namespace leadthrough {

struct TrackOptions {
  // What counts as reached; most samples come far closer.
  IkTolerance tolerance{1e-5, 1e-5};
  int max_iterations = 60;  // a sample
};

struct Track {
  Rows q;  // one row a sample, inside the limits
  Eigen::VectorXd position_errors;
  Eigen::VectorXd orientation_errors;
  std::vector<IkStatus> status;

  // The first sample that was not reached, or the number of samples.
  Eigen::Index reached() const;
};

// positions: one row a sample; orientations (w, x, y, z) may have no rows. start: the
// configuration before the first sample. max_steps: for each sample, the largest change of each
// joint from the sample before. midrange: for each sample, the share of the way to the middle of
// the ranges that a redundant arm takes in the null space.
Track track(const Chain& chain, const Eigen::Ref<const Rows3>& positions,
            const Eigen::Ref<const Rows4>& orientations,
            const Eigen::Ref<const Eigen::VectorXd>& start, const Eigen::Ref<const Rows>& max_steps,
            const Eigen::Ref<const Eigen::VectorXd>& midrange, const TrackOptions& options = {});

}  // namespace leadthrough
