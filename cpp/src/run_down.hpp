#pragma once

#include <cmath>
#include <cstddef>

#include "leadthrough/chain.hpp"

namespace leadthrough {

// Runs down the chain; at_joint(i, z axis, origin) sees each joint's line in the base frame.
template <typename AtJoint>
Pose run_down(const Chain& chain, const double* q, AtJoint at_joint) {
  const auto n = static_cast<std::size_t>(chain.joints());
  Eigen::Matrix3d rotation = chain.fixed[0].rotation;
  Eigen::Vector3d position = chain.fixed[0].position;
  for (std::size_t i = 0; i < n; ++i) {
    at_joint(i, rotation.col(2), position);
    if (chain.prismatic[i]) {
      position += q[i] * rotation.col(2);
    } else {
      const double cosine = std::cos(q[i]);
      const double sine = std::sin(q[i]);
      const Eigen::Vector3d x = rotation.col(0);
      rotation.col(0) = cosine * x + sine * rotation.col(1);
      rotation.col(1) = cosine * rotation.col(1) - sine * x;
    }
    position += rotation * chain.fixed[i + 1].position;
    rotation = (rotation * chain.fixed[i + 1].rotation).eval();
  }
  return {rotation, position};
}

}  // namespace leadthrough
