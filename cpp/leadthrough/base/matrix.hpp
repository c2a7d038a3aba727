#pragma once

#include <Eigen/Core>

#include "leadthrough/base/layout.hpp"

namespace leadthrough {

using Vector6 = Eigen::Matrix<double, 6, 1>;

// In C order, as NumPy's arrays.
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Rows4 = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;

}  // namespace leadthrough
