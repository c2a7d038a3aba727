#include "time/differences.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace leadthrough {

using Eigen::ArrayXd;
using Eigen::Index;

namespace {

ArrayXd inverse(const Eigen::VectorXd& limits, double period_power) {
  // A joint whose limit is zero does not move: its differences are rounding.
  return (limits.array() > 0.0).select(limits.array().inverse() / period_power, 0.0);
}

using Worst = std::array<double, 3>;

// The last value of every joint and its last differences of orders 1 and 2, row by row, and what
// differences of orders 1 to 3 are measured by.
struct Table {
  Rows last, weight;
};

// The largest of the new differences of each order. Loops over the six or seven joints of an arm
// unroll: their number is known when compiling.
template <typename Joints>
Worst add(Joints joints, const double* now, Table& table) {
  Worst worst{};
  double* value = table.last.data();
  double* slope = value + joints;
  double* bend = slope + joints;
  const double* weight = table.weight.data();
  for (Index j = 0; j < joints; ++j) {
    const double first = now[j] - value[j];
    const double second = first - slope[j];
    const double third = second - bend[j];
    value[j] = now[j];
    slope[j] = first;
    bend[j] = second;
    worst[0] = std::max(worst[0], std::abs(first) * weight[j]);
    worst[1] = std::max(worst[1], std::abs(second) * weight[joints + j]);
    worst[2] = std::max(worst[2], std::abs(third) * weight[2 * joints + j]);
  }
  return worst;
}

Worst added(Index joints, const double* now, Table& table) {
  if (joints == 6) return add(std::integral_constant<Index, 6>{}, now, table);
  if (joints == 7) return add(std::integral_constant<Index, 7>{}, now, table);
  return add(joints, now, table);
}

}  // namespace

void measure_differences(const PolynomialPath& path, const PathGrid& grid, const RateLimits& limits,
                         const std::vector<double>& lengths, double period, const Rest& rest,
                         DifferenceRatios& ratios) {
  const Index joints = path.joints(), samples = static_cast<Index>(lengths.size());
  Table table{Rows::Zero(3, joints), Rows(3, joints)};
  table.weight.row(0) = inverse(limits.velocity, period);
  table.weight.row(1) = inverse(limits.acceleration, period * period);
  table.weight.row(2) = inverse(limits.jerk, period * period * period);
  ArrayXd now(joints);
  for (auto& order : ratios.each) order.assign(lengths.size(), 0.0);
  ratios.largest.fill(0.0);

  Index cell = 0, piece = 0;
  const auto visit = [&](Index k, Index known) {
    const auto at = static_cast<std::size_t>(std::clamp<Index>(k, 0, samples - 1));
    const double s = parameter_at(grid, lengths[at], cell);
    piece = path.piece_of(s, piece);
    path.position(s, piece, now.data());
    const Worst worst = added(joints, now.data(), table);
    for (std::size_t order = 0; order < 3 && known > static_cast<Index>(order); ++order) {
      ratios.each[order][at] = std::max(ratios.each[order][at], worst[order]);
      ratios.largest[order] = std::max(ratios.largest[order], worst[order]);
    }
  };
  const Index first = rest.start ? -3 : 0, end = samples + (rest.end ? 3 : 0);
  for (Index k = first; k < end; ++k) visit(k, k - first);
}

}  // namespace leadthrough
