#pragma once

// What the samples of a motion tell by themselves.

#include <vector>

#include "base/matrix.hpp"

namespace leadthrough {

struct Derivatives {
  Rows velocities, accelerations;  // (n, joints)
};

// Central differences of positions (n, joints) at times (n), n >= 2. `beyond` has one more sample
// before the first and one after the last, each as far in time as the next step inside.
Derivatives central_differences(const Eigen::Ref<const Eigen::VectorXd>& times,
                                const Eigen::Ref<const Rows>& positions,
                                const Eigen::Ref<const Rows>& beyond);

// The samples between first and last to which a motion comes to be at rest.
std::vector<Eigen::Index> stops(const Eigen::Ref<const Rows>& positions,
                                const Eigen::Ref<const Rows>& velocities);

// The least and the largest value of each column, at least one row.
struct Extent {
  Eigen::VectorXd least, largest;
};
Extent extent_of(const Eigen::Ref<const Rows>& rows);

}  // namespace leadthrough
