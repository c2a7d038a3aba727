#pragma once

// Weighted means of rotations: minimisers of the weighted sum of squared geodesic distances
// (Karcher means), independent of the quaternions' signs.

#include "leadthrough/rotation/so3.hpp"

namespace leadthrough::so3 {

struct Means {
  Quaternions means;      // one a column of the layers, in the hemisphere of the first layer
  Eigen::VectorXd reach;  // largest distance from the rotations' unweighted mean, rad
};

// `layers` holds as many blocks of rows as there are weights, all > 0; row i of every block goes
// into mean i. A reach below pi / 2 proves that the mean is the only one (Afsari 2011, "Riemannian
// L^p center of mass"); beyond it, the mean is one of several candidates.
Means mean_batch(const Rows4Ref& layers, const VectorRef& weights);

}  // namespace leadthrough::so3
