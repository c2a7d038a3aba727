#include "leadthrough/guard/step_limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace leadthrough::guard {

namespace {

using Eigen::Index;

// Less than the tolerance of limit checks, 1e-6.
constexpr double kExcess = 0.999e-6;
// Positions may be this far beyond a limit, rad or m: a file's digits.
constexpr double kRounding = 1e-9;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// Row k of the history and the samples after it.
struct Stream {
  const RowsRef& history;
  const RowsRef& samples;

  double operator()(Index k, Index joint) const {
    return k < 0 ? history(kHistory + k, joint) : samples(k, joint);
  }
};

// Differences of order 1 to 3 that end at row k.
std::array<double, 3> differences(const Stream& q, Index k, Index joint) {
  const double a = q(k, joint), b = q(k - 1, joint), c = q(k - 2, joint), d = q(k - 3, joint);
  const double first = a - b, before = b - c, earlier = c - d;
  return {first, first - before, (first - before) - (before - earlier)};
}

std::optional<Excess> excess_at(const StepLimits& limits, const Stream& q, Index k, Index joint) {
  const double here = q(k, joint);
  if (!(here >= limits.lower[joint] - kRounding && here <= limits.upper[joint] + kRounding))
    return Excess{0, k, joint, here};
  const auto found = differences(q, k, joint);
  double size = 0.0;
  for (Index back = 0; back <= kHistory; ++back)
    size = std::max(size, std::abs(q(k - back, joint)));
  double rounding = kEpsilon * size;
  for (int order = 1; order <= 3; ++order) {
    rounding *= 2.0;
    const double used = std::abs(found[static_cast<std::size_t>(order - 1)]) - rounding;
    const double limit = limits.difference(order)[joint];
    if (!(used <= limit * (1.0 + kExcess))) return Excess{order, k, joint, used / limit};
  }
  return std::nullopt;
}

}  // namespace

std::optional<Excess> first_excess(const StepLimits& limits, const RowsRef& history,
                                   const RowsRef& samples) {
  const Stream q{history, samples};
  for (Index k = 0; k < samples.rows(); ++k)
    for (Index joint = 0; joint < samples.cols(); ++joint)
      if (const auto found = excess_at(limits, q, k, joint)) return found;
  return std::nullopt;
}

Eigen::VectorXd slowdowns(const StepLimits& limits, const RowsRef& samples) {
  // The largest use of the limits of order 1 to 3 in each row, over all joints.
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> used =
      Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>::Zero(samples.rows(), 3);
  for (Index j = 0; j < samples.cols(); ++j) {
    std::array<double, 3> last{};  // differences of order 0 to 2
    for (Index k = 0; k < samples.rows(); ++k) {
      double value = samples(k, j);
      for (int order = 1; order <= 3; ++order) {
        const auto o = static_cast<std::size_t>(order - 1);
        const double change = value - last[o];
        last[o] = value;
        value = change;
        if (k < order) break;
        used(k, order - 1) =
            std::max(used(k, order - 1), std::abs(change) / limits.difference(order)[j]);
      }
    }
  }
  // Roots are the most expensive part, and few rows need them.
  Eigen::VectorXd result = used.rowwise().maxCoeff();
  for (Index k = 0; k < result.size(); ++k)
    if (result[k] > 1.0)
      result[k] = std::max({used(k, 0), std::sqrt(used(k, 1)), std::cbrt(used(k, 2))});
  return result;
}

}  // namespace leadthrough::guard
