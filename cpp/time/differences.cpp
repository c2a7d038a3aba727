#include "time/differences.hpp"

#include <algorithm>
#include <cmath>

namespace leadthrough {

using Eigen::ArrayXd;
using Eigen::Index;

namespace {

ArrayXd inverse(const Eigen::VectorXd& limits, double period_power) {
  // A joint whose limit is zero does not move: its differences are rounding.
  return (limits.array() > 0.0).select(limits.array().inverse() / period_power, 0.0);
}

}  // namespace

void measure_differences(const PolynomialPath& path, const PathGrid& grid, const RateLimits& limits,
                         const std::vector<double>& lengths, double period, const Rest& rest,
                         DifferenceRatios& ratios) {
  const Index joints = path.joints(), samples = static_cast<Index>(lengths.size());
  const std::array<ArrayXd, 3> weight{inverse(limits.velocity, period),
                                      inverse(limits.acceleration, period * period),
                                      inverse(limits.jerk, period * period * period)};
  // The last value and its last differences of orders 1 and 2.
  Eigen::Array<double, Eigen::Dynamic, 3> table(joints, 3);
  table.setZero();
  ArrayXd now(joints);
  for (auto& order : ratios.each) order.assign(lengths.size(), 0.0);
  ratios.largest.fill(0.0);

  Index cell = 0, piece = 0;
  const auto visit = [&](Index k, Index known) {
    const auto at = static_cast<std::size_t>(std::clamp<Index>(k, 0, samples - 1));
    const double s = parameter_at(grid, lengths[at], cell);
    piece = path.piece_of(s, piece);
    path.position(s, piece, now.data());
    std::array<double, 3> worst{};
    for (Index j = 0; j < joints; ++j) {
      double value = now[j];
      for (Index order = 0; order < 3; ++order) {
        const double difference = value - table(j, order);
        table(j, order) = value;
        value = difference;
        const auto o = static_cast<std::size_t>(order);
        worst[o] = std::max(worst[o], std::abs(difference) * weight[o][j]);
      }
    }
    for (std::size_t order = 0; order < 3 && known > static_cast<Index>(order); ++order) {
      ratios.each[order][at] = std::max(ratios.each[order][at], worst[order]);
      ratios.largest[order] = std::max(ratios.largest[order], worst[order]);
    }
  };
  const Index first = rest.start ? -3 : 0, end = samples + (rest.end ? 3 : 0);
  for (Index k = first; k < end; ++k) visit(k, k - first);
}

}  // namespace leadthrough
