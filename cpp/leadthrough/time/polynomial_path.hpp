#pragma once

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

// A path of polynomial pieces over a parameter s. Piece p spans breaks[p] to breaks[p + 1]; its
// coefficients of (s - breaks[p])^k, k rising, are the rows from p * terms on, one column a joint.
struct PolynomialPath {
  Eigen::VectorXd breaks;
  Rows coefficients;

  Eigen::Index joints() const { return coefficients.cols(); }
  Eigen::Index pieces() const { return breaks.size() - 1; }
  Eigen::Index terms() const { return coefficients.rows() / pieces(); }

  // The piece of s, looked for from `piece` on; the outer pieces reach beyond the ends.
  Eigen::Index piece_of(double s, Eigen::Index piece) const;
  // With the first two derivatives by s.
  void position(double s, Eigen::Index piece, double* q, double* first, double* second) const;
};

}  // namespace leadthrough
