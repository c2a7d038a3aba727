#include "leadthrough/learn/basis_functions.hpp"

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {
namespace {

// Those of orders from the first to the last, below each other.
Rows basis_of_orders(const VectorRef& phases, const VectorRef& centres, double sharpness,
                     bool periodic, int first, int last) {
  const Eigen::Index count = phases.size();
  Rows result((last - first + 1) * count, centres.size());
  NormalisedBasis basis(centres, sharpness, periodic);
  for (Eigen::Index i = 0; i < count; ++i) {
    check_interrupt(i);
    const Rows& rows = basis.at(phases[i], last);
    for (int order = first; order <= last; ++order)
      result.row((order - first) * count + i) = rows.row(order);
  }
  return result;
}

}  // namespace

NormalisedBasis::NormalisedBasis(Eigen::VectorXd centres, double sharpness, bool periodic)
    : centres_(centres.transpose()),
      value_(centres.size()),
      slope_(centres.size()),
      bend_(centres.size()),
      sharpness_(sharpness),
      periodic_(periodic),
      rows_(3, centres.size()) {}

// A function is f = exp(g) / sum exp(g), whose logarithm has the slope g' - sum f g'.
const Rows& NormalisedBasis::at(double phase, int most) {
  slope_ = (phase - centres_.array()).matrix();  // the distances, until they are g'
  if (periodic_) {
    slope_ *= kTurn;
    bend_ = slope_.array().cos();
    value_ = sharpness_ * (bend_.array() - 1.0);
    bend_ *= -kTurn * kTurn * sharpness_;
    slope_ = -kTurn * sharpness_ * slope_.array().sin();
  } else {
    value_ = -0.5 * sharpness_ * slope_.array().square();
    bend_.setConstant(-sharpness_);
    slope_ *= -sharpness_;
  }
  value_ = value_.array().exp();
  value_ /= value_.sum();
  const auto f = value_.array();
  const auto slope = slope_.array();
  rows_.row(0) = value_;
  if (most == 0) return rows_;
  const double rise = (f * slope).sum();
  rows_.row(1) = f * (slope - rise);
  if (most == 1) return rows_;
  const auto bend = bend_.array() + slope.square();
  rows_.row(2) = f * (bend - (f * bend).sum() - 2.0 * rise * (slope - rise));
  return rows_;
}

Rows normalised_basis(const VectorRef& phases, const VectorRef& centres, double sharpness,
                      bool periodic, int order) {
  check_argument(order >= 0 && order <= 2, "order: expected 0 to 2");
  return basis_of_orders(phases, centres, sharpness, periodic, order, order);
}

Rows basis_and_derivatives(const VectorRef& phases, const VectorRef& centres, double sharpness,
                           bool periodic, int most) {
  return basis_of_orders(phases, centres, sharpness, periodic, 0, most);
}

}  // namespace leadthrough
