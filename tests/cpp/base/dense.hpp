#pragma once

// Decompositions that tests compare with, compiled once for all of them.

#include <Eigen/Core>

namespace leadthrough::test {

// In descending order.
Eigen::VectorXd singular_values(const Eigen::MatrixXd& matrix);

// Moore and Penrose's; the inverse of a matrix that has one.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& matrix);

}  // namespace leadthrough::test
