#include "leadthrough/learn/basis_functions.hpp"

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {
namespace {

// A function is exp(g); here g and its derivatives, a value for each centre.
struct Exponents {
  Eigen::RowVectorXd value, slope, bend;

  explicit Exponents(Eigen::Index count) : value(count), slope(count), bend(count) {}

  void at(double phase, const Eigen::Ref<const Eigen::VectorXd>& centres, double sharpness,
          bool periodic) {
    slope = (phase - centres.transpose().array()).matrix();  // the distances, until the last line
    if (periodic) {
      slope *= kTurn;
      value = sharpness * (slope.array().cos() - 1.0);
      bend = -kTurn * kTurn * sharpness * slope.array().cos();
      slope = -kTurn * sharpness * slope.array().sin();
    } else {
      value = -0.5 * sharpness * slope.array().square();
      bend.setConstant(-sharpness);
      slope *= -sharpness;
    }
  }
};

// Those of orders from the first to the last, below each other.
Rows basis_of_orders(const Eigen::Ref<const Eigen::VectorXd>& phases,
                     const Eigen::Ref<const Eigen::VectorXd>& centres, double sharpness,
                     bool periodic, int first, int last) {
  const Eigen::Index count = phases.size();
  Rows result((last - first + 1) * count, centres.size());
  Exponents exponents(centres.size());
  Eigen::RowVectorXd values(centres.size());
  const auto f = values.array();
  const auto slope = exponents.slope.array();
  for (Eigen::Index i = 0; i < count; ++i) {
    check_interrupt(i);
    const auto row = [&](int order) { return result.row((order - first) * count + i).array(); };
    exponents.at(phases[i], centres, sharpness, periodic);
    values = exponents.value.array().exp();
    values /= values.sum();
    if (first == 0) row(0) = f;
    // f = b / sum b, whose logarithm has the slope g' - sum f g'.
    const double rise = last > 0 ? (f * slope).sum() : 0.0;
    if (first <= 1 && last >= 1) row(1) = f * (slope - rise);
    if (last < 2) continue;
    const auto bend = exponents.bend.array() + slope.square();
    row(2) = f * (bend - (f * bend).sum() - 2.0 * rise * (slope - rise));
  }
  return result;
}

}  // namespace

Rows normalised_basis(const Eigen::Ref<const Eigen::VectorXd>& phases,
                      const Eigen::Ref<const Eigen::VectorXd>& centres, double sharpness,
                      bool periodic, int order) {
  check_argument(order >= 0 && order <= 2, "order: expected 0 to 2");
  return basis_of_orders(phases, centres, sharpness, periodic, order, order);
}

Rows basis_and_derivatives(const Eigen::Ref<const Eigen::VectorXd>& phases,
                           const Eigen::Ref<const Eigen::VectorXd>& centres, double sharpness,
                           bool periodic, int most) {
  return basis_of_orders(phases, centres, sharpness, periodic, 0, most);
}

}  // namespace leadthrough
