#pragma once

// From a chain's joints to its moving joints, the chain's geometry, and back.

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "leadthrough/arm/chain.hpp"

namespace leadthrough {

using MovingValues = std::array<double, kMaxJoints>;

inline std::size_t moving_count(const Chain& chain) {
  return static_cast<std::size_t>(chain.moving);
}

// Values of the moving joints: q itself or, if joints mimic, computed into `room`.
inline const double* moving_values(const Chain& chain, const double* q, MovingValues& room) {
  if (!chain.mimics) return q;
  for (std::size_t k = 0; k < moving_count(chain); ++k)
    room[k] = chain.drives[k].multiplier * q[chain.drives[k].joint] + chain.drives[k].offset;
  return room.data();
}

// The same for derivatives of q in time.
inline const double* moving_rates(const Chain& chain, const double* rates, MovingValues& room) {
  if (!chain.mimics) return rates;
  for (std::size_t k = 0; k < moving_count(chain); ++k)
    room[k] = chain.drives[k].multiplier * rates[chain.drives[k].joint];
  return room.data();
}

// Columns of the moving joints become columns of the joints that drive them.
inline void gather(const Chain& chain, JacobianColumns& columns) {
  if (!chain.mimics) return;
  JacobianColumns sums;
  std::fill_n(sums.begin(), chain.joints(), Vector6::Zero());
  for (std::size_t k = 0; k < moving_count(chain); ++k)
    sums[static_cast<std::size_t>(chain.drives[k].joint)] +=
        chain.drives[k].multiplier * columns[k];
  std::copy_n(sums.begin(), chain.joints(), columns.begin());
}

// values: of the moving joints. at_joint(k, z axis, origin) sees each one's line in the base frame.
template <typename AtJoint>
Transform run_down(const Chain& chain, const double* values, AtJoint at_joint) {
  Eigen::Matrix3d rotation = chain.fixed[0].rotation;
  Eigen::Vector3d position = chain.fixed[0].position;
  for (std::size_t k = 0; k < moving_count(chain); ++k) {
    at_joint(k, rotation.col(2), position);
    if (chain.prismatic[k]) {
      position += values[k] * rotation.col(2);
    } else {
      const double cosine = std::cos(values[k]);
      const double sine = std::sin(values[k]);
      const Eigen::Vector3d x = rotation.col(0);
      rotation.col(0) = cosine * x + sine * rotation.col(1);
      rotation.col(1) = cosine * rotation.col(1) - sine * x;
    }
    position += rotation * chain.fixed[k + 1].position;
    rotation = (rotation * chain.fixed[k + 1].rotation).eval();
  }
  return {rotation, position};
}

}  // namespace leadthrough
