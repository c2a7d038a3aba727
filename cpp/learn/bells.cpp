#include "learn/bells.hpp"

#include <algorithm>
#include <cstddef>

#include "base/constants.hpp"
#include "base/parallel.hpp"

namespace leadthrough {
namespace {

constexpr Eigen::Index kRun = 256;  // phases that a thread takes at a time

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

}  // namespace

Rows normalised_bells(const Eigen::Ref<const Eigen::VectorXd>& phases,
                      const Eigen::Ref<const Eigen::VectorXd>& centres, double sharpness,
                      bool periodic, int order, int threads) {
  Rows result(phases.size(), centres.size());
  const auto fill = [&](Eigen::Index i, Exponents& exponents) {
    exponents.at(phases[i], centres, sharpness, periodic);
    auto row = result.row(i).array();
    row = exponents.value.array().exp();
    row /= row.sum();
    // f = b / sum b, whose logarithm has the slope g' - sum f g'.
    const auto slope = exponents.slope.array();
    const double rise = order > 0 ? (row * slope).sum() : 0.0;
    if (order == 1) row *= slope - rise;
    if (order == 2) {
      const double bend = (row * (exponents.bend.array() + slope.square())).sum();
      row *= exponents.bend.array() + slope.square() - bend - 2.0 * rise * (slope - rise);
    }
  };
  const Eigen::Index runs = (phases.size() + kRun - 1) / kRun;
  for_each_index(static_cast<std::size_t>(runs), threads, [&](std::size_t run) {
    Exponents exponents(centres.size());
    const Eigen::Index first = static_cast<Eigen::Index>(run) * kRun;
    const Eigen::Index end = std::min(first + kRun, phases.size());
    for (Eigen::Index i = first; i < end; ++i) fill(i, exponents);
  });
  return result;
}

}  // namespace leadthrough
