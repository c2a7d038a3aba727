#pragma once

// The least slowing down, sample by sample, that brings a joint path inside its velocity and
// acceleration limits. Reachability analysis along the path as in Pham and Pham 2018, with the
// path's own pace as the upper bound of speed.

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

struct Slowing {
  Eigen::VectorXd times;  // s, the first as given, no interval shorter than given
  int stuck = -1;         // a joint that moves and must not; the times are then meaningless
};

// times: s, at least one, increasing. q: one row a sample. velocity, acceleration: one a joint,
// infinite where there is no limit. Accelerations are second differences of the samples, and the
// arm stands still before the first and after the last.
Slowing slow_down(const VectorRef& times, const RowsRef& q, const VectorRef& velocity,
                  const VectorRef& acceleration);

}  // namespace leadthrough
