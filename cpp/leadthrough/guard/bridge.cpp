#include "leadthrough/guard/bridge.hpp"

#include <algorithm>

namespace leadthrough::guard {

namespace {

using Eigen::Index;

constexpr Index kLanding = 3;  // rows of the target that fix the polynomial
constexpr Index kKnots = kHistory + kLanding;
// Each attempt takes longer than the one before by this fraction.
constexpr Index kFractions = 8;

// Newton's form through rows at times -2, -1, 0 and steps, steps + 1, steps + 2.
class Quintic {
 public:
  Quintic(const RowsRef& history, const RowsRef& landing, Index steps)
      : table_(kKnots, history.cols()) {
    for (Index i = 0; i < kHistory; ++i) times_[i] = static_cast<double>(i + 1 - kHistory);
    for (Index i = 0; i < kLanding; ++i) times_[kHistory + i] = static_cast<double>(steps + i);
    table_ << history, landing;
    for (Index order = 1; order < kKnots; ++order)
      for (Index i = kKnots - 1; i >= order; --i)
        table_.row(i) = (table_.row(i) - table_.row(i - 1)) / (times_[i] - times_[i - order]);
  }

  template <typename Row>
  void at(double time, Row row) const {
    row = table_.row(kKnots - 1);
    for (Index i = kKnots - 2; i >= 0; --i) row = row * (time - times_[i]) + table_.row(i);
  }

 private:
  Rows table_;
  Eigen::Array<double, kKnots, 1> times_;
};

// skip: rows of the target for each step after the first.
std::optional<Bridge> shortest(const StepLimits& limits, const RowsRef& history,
                               const RowsRef& target, Index most_steps, Index skip) {
  Rows stream(kHistory + most_steps - 1 + kLanding, limits.joints());
  stream.topRows(kHistory) = history;
  for (Index steps = 1; steps <= most_steps; steps += 1 + steps / kFractions) {
    const Index skipped = skip * (steps - 1);
    if (skipped + kLanding > target.rows()) break;
    const auto landing = target.middleRows(skipped, kLanding);
    const Quintic quintic(history, landing, steps);
    // Most attempts leave a limit within a few rows.
    bool satisfied = true;
    for (Index k = 1; satisfied && k < steps + kLanding; ++k) {
      const Index row = kHistory - 1 + k;
      if (k < steps)
        quintic.at(static_cast<double>(k), stream.row(row));
      else
        stream.row(row) = landing.row(k - steps);
      satisfied = keeps(limits, stream, row);
    }
    if (satisfied) return Bridge{stream.middleRows(kHistory, steps - 1), skipped};
  }
  return std::nullopt;
}

}  // namespace

std::optional<Bridge> bridge_to_start(const StepLimits& limits, const RowsRef& history,
                                      const RowsRef& target, Index most_steps) {
  return shortest(limits, history, target, most_steps, 0);
}

std::optional<Bridge> bridge_on_time(const StepLimits& limits, const RowsRef& history,
                                     const RowsRef& target, Index most_steps) {
  return shortest(limits, history, target, most_steps, 1);
}

}  // namespace leadthrough::guard
