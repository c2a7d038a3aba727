// Reachability analysis over the squared speed (Pham & Pham 2018): backwards, the interval of
// speeds at each point of the grid from which the rest of the path can be driven; forwards, the
// largest acceleration that stays inside these intervals.
//
// Within a cell the rows leave an interval of accelerations whose ends are a convex and a concave
// function of x, piecewise linear. The x for which it is not empty are found by Newton's method on
// its length, which is concave: from outside it comes up to the zero in finitely many steps and
// never beyond.

#include "leadthrough/time/reachability.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

// A row whose gain is smaller than this share of the largest in the grid does not act on u.
constexpr double kNegligibleGain = 1e-9;
// Rounding error of a sum that should be zero, relative to its terms.
constexpr double kRounding = 1e-12;
constexpr double kSameSpeed = 1e-9;
constexpr int kMaxNewtonSteps = 100;

// A bound on u that is linear in x: u <= or >= offset + slope * x.
struct Line {
  double offset, slope;
  double at(double x) const { return offset + slope * x; }
  double size(double x) const { return std::abs(offset) + std::abs(slope) * x; }
};

// Bounds in an order; of equal ones the first is the tightest.
class Lines {
 public:
  explicit Lines(std::size_t most) : offset_(most), slope_(most) {}

  void clear() { count_ = 0; }

  // Without a branch: one that is not finite is overwritten by the next.
  void push(const Line& line) {
    offset_[count_] = line.offset;
    slope_[count_] = line.slope;
    count_ += std::isfinite(line.offset) ? 1 : 0;
  }

  Line highest(double x) const {
    return tightest(x, [](double a, double b) { return a > b; });
  }
  Line lowest(double x) const {
    return tightest(x, [](double a, double b) { return a < b; });
  }

 private:
  template <class Tighter>
  Line tightest(double x, Tighter tighter) const {
    std::size_t best = 0;
    double value = offset_[0] + slope_[0] * x;
    for (std::size_t k = 1; k < count_; ++k) {
      const double other = offset_[k] + slope_[k] * x;
      const bool better = tighter(other, value);
      value = better ? other : value;
      best = better ? k : best;
    }
    return {offset_[best], slope_[best]};
  }

  std::vector<double> offset_, slope_;
  std::size_t count_ = 0;
};

class Cell {
 public:
  explicit Cell(Eigen::Index rows)
      : floors_(static_cast<std::size_t>(2 * rows + 2)),
        ceilings_(static_cast<std::size_t>(2 * rows + 2)) {}

  // Rows of points i and i + 1, and x at i + 1 inside `next`.
  void set(const SpeedBounds& bounds, Eigen::Index i, double least_gain,
           const SpeedInterval& next) {
    floors_.clear();
    ceilings_.clear();
    const double length = bounds.grid[i + 1] - bounds.grid[i];
    x_ = {0.0, bounds.fastest[i]};
    for (Eigen::Index j = 0; j < bounds.gain.cols(); ++j) {
      const double bend = bounds.bend(i + 1, j);
      add(bounds.gain(i, j), bounds.bend(i, j), bounds.lower(i, j), bounds.upper(i, j), least_gain);
      add(bounds.gain(i + 1, j) + 2.0 * length * bend, bend, bounds.lower(i + 1, j),
          bounds.upper(i + 1, j), least_gain);
    }
    const double share = 0.5 / length;
    floors_.push({next.low * share, -share});
    ceilings_.push({std::min(next.high, bounds.fastest[i + 1]) * share, -share});
  }

  Line floor(double x) const { return floors_.highest(x); }
  Line ceiling(double x) const { return ceilings_.lowest(x); }

  // The x that leave an acceleration; low > high where none does.
  SpeedInterval controllable() const {
    if (x_.low > x_.high) return x_;
    const double high = outermost(x_.high, x_.low);
    const double low = outermost(x_.low, x_.high);
    // If a single x is left, both ends agree up to rounding.
    return {low <= high * (1.0 + kSameSpeed) ? std::min(low, high) : low, high};
  }

 private:
  void add(double gain, double bend, double lower, double upper, double least_gain) {
    if (std::abs(gain) <= least_gain) {
      bound_speed(bend, lower, upper);
      return;
    }
    const double inverse = 1.0 / gain;
    const Line low{lower * inverse, -bend * inverse}, high{upper * inverse, -bend * inverse};
    floors_.push(gain < 0.0 ? high : low);
    ceilings_.push(gain < 0.0 ? low : high);
  }

  void bound_speed(double bend, double lower, double upper) {
    if (bend == 0.0) return;
    const double a = lower / bend, b = upper / bend;
    x_.low = std::max(x_.low, std::min(a, b));
    x_.high = std::min(x_.high, std::max(a, b));
  }

  // From x towards `other`, the first x that leaves an acceleration; beyond `other` if none does.
  double outermost(double x, double other) const {
    const double direction = other < x ? -1.0 : 1.0;
    double before = 0.0;  // of which a step is rounded: it may end slightly beyond the zero
    for (int step = 0; step < kMaxNewtonSteps; ++step) {
      const Line low = floor(x), high = ceiling(x);
      const double length = high.at(x) - low.at(x);
      if (length >= -kRounding * (low.size(x) + high.size(x))) return x;
      const double slope = high.slope - low.slope, next = x - length / slope;
      if (slope * direction <= 0.0 && !(std::abs(next - x) <= kRounding * before)) break;
      if (next == x) return x;
      before = std::abs(x);
      x = next;
      const double beyond = (x - other) * direction;
      if (beyond > kRounding * before) break;
      if (beyond > 0.0) x = other;
    }
    return direction * kInfinity;
  }

  Lines floors_, ceilings_;
  SpeedInterval x_{0.0, kInfinity};
};

// The two passes, which leave out what is as it was.
class Passes {
 public:
  Passes(const SpeedBounds& bounds, SpeedProfile& profile, const std::vector<char>& changed)
      : bounds_(bounds),
        profile_(profile),
        cell_(bounds.gain.cols()),
        least_gain_(kNegligibleGain *
                    (bounds.gain.size() > 0 ? bounds.gain.cwiseAbs().maxCoeff() : 0.0)) {
    const auto points = static_cast<std::size_t>(bounds.grid.size());
    const bool again = changed.size() == points && profile.reach.size() == points &&
                       profile.status == SpeedStatus::kOk;
    changed_ = again ? changed : std::vector<char>(points, 1);
    if (again) return;
    profile.reach.assign(points, {0.0, 0.0});
    profile.squared.setZero(bounds.grid.size());
  }

  // The point from which there is no motion; -1 if there is one from all.
  Eigen::Index backward(double x_end) {
    const Eigen::Index points = bounds_.grid.size();
    keep(points - 1, {x_end, x_end});
    for (Eigen::Index i = points - 2; i >= 0; --i) {
      check_interrupt(i);
      if (!changed(i) && !changed(i + 1)) continue;
      cell_.set(bounds_, i, least_gain_, reach(i + 1));
      const SpeedInterval x = cell_.controllable();
      if (!(x.low <= x.high)) return i;
      keep(i, x);
    }
    return -1;
  }

  void forward(double x) {
    Eigen::VectorXd& squared = profile_.squared;
    bool other = changed(0) || squared[0] != x;
    squared[0] = x;
    for (Eigen::Index i = 0; i + 1 < squared.size(); ++i) {
      check_interrupt(i);
      if (!other && !changed(i) && !changed(i + 1)) continue;
      const SpeedInterval& next = reach(i + 1);
      cell_.set(bounds_, i, least_gain_, next);
      const double length = bounds_.grid[i + 1] - bounds_.grid[i];
      x = squared[i];
      x = std::clamp(x + 2.0 * length * cell_.ceiling(x).at(x), next.low, next.high);
      other = squared[i + 1] != x;
      squared[i + 1] = x;
    }
  }

 private:
  bool changed(Eigen::Index i) const { return changed_[static_cast<std::size_t>(i)] != 0; }
  SpeedInterval& reach(Eigen::Index i) { return profile_.reach[static_cast<std::size_t>(i)]; }

  // Another interval is another bound for what comes before.
  void keep(Eigen::Index i, const SpeedInterval& x) {
    if (reach(i).low != x.low || reach(i).high != x.high) changed_[static_cast<std::size_t>(i)] = 1;
    reach(i) = x;
  }

  const SpeedBounds& bounds_;
  SpeedProfile& profile_;
  std::vector<char> changed_;
  Cell cell_;
  double least_gain_;
};

}  // namespace

void fastest_profile(const SpeedBounds& bounds, double x_start, double x_end, SpeedProfile& profile,
                     const std::vector<char>& changed) {
  Passes passes(bounds, profile, changed);
  const auto end = [&](SpeedStatus status, Eigen::Index i) {
    profile.status = status;
    profile.failed_at = i;
  };
  const Eigen::Index last = bounds.grid.size() - 1;
  if (x_end > bounds.fastest[last]) return end(SpeedStatus::kEndTooFast, last);
  const Eigen::Index stuck = passes.backward(x_end);
  if (stuck >= 0) return end(SpeedStatus::kNoMotion, stuck);
  const SpeedInterval& first = profile.reach.front();
  if (x_start > first.high * (1.0 + kSameSpeed) || x_start < first.low * (1.0 - kSameSpeed))
    return end(SpeedStatus::kStartTooFast, 0);
  passes.forward(x_start);
  end(SpeedStatus::kOk, -1);
}

}  // namespace leadthrough
