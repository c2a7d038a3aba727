#pragma once

// Bell-shaped functions over a phase, divided by their sum.

#include <Eigen/Core>

namespace leadthrough {

using BellMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// exp(-sharpness (u - c)^2 / 2) about each centre, or with period 1 exp(sharpness (cos 2 pi (u - c)
// - 1)), over their sum: a row a phase. order: of the derivative by the phase, 0 to 2.
BellMatrix normalised_bells(const Eigen::Ref<const Eigen::VectorXd>& phases,
                            const Eigen::Ref<const Eigen::VectorXd>& centres, double sharpness,
                            bool periodic, int order);

}  // namespace leadthrough
