#pragma once

#include <Eigen/Core>

#include "leadthrough/base/layout.hpp"

namespace leadthrough {

using Vector6 = Eigen::Matrix<double, 6, 1>;

// In C order, as NumPy's arrays.
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Rows4 = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;

// Arguments that are only read, whoever owns their memory.
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
using RowsRef = Eigen::Ref<const Rows>;
using Rows3Ref = Eigen::Ref<const Rows3>;
using Rows4Ref = Eigen::Ref<const Rows4>;

}  // namespace leadthrough
