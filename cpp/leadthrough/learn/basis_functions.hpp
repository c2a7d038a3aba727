#pragma once

// Normalised Gaussian or von Mises basis functions over a phase.

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

// exp(-sharpness (u - c)^2 / 2) about each centre, or with period 1 exp(sharpness (cos 2 pi (u - c)
// - 1)), over their sum: a row a phase. order: of the derivative by the phase, 0 to 2.
Rows normalised_basis(const VectorRef& phases, const VectorRef& centres, double sharpness,
                      bool periodic, int order);

// The same at one phase after the other, in work space of its own.
class NormalisedBasis {
 public:
  NormalisedBasis(Eigen::VectorXd centres, double sharpness, bool periodic);

  // Row i: the derivatives of order i by the phase, up to order `most`; until the next call.
  const Rows& at(double phase, int most);

 private:
  Eigen::RowVectorXd centres_, value_, slope_, bend_;
  double sharpness_;
  bool periodic_;
  Rows rows_;
};

// Those of order 0 and their derivatives up to order `most`, below each other.
Rows basis_and_derivatives(const VectorRef& phases, const VectorRef& centres, double sharpness,
                           bool periodic, int most);

}  // namespace leadthrough
