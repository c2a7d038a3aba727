// Reachability analysis over the squared speed (Pham & Pham 2018): backwards, the interval of
// speeds at each point of the grid from which the rest of the path can be driven; forwards, the
// largest acceleration that stays inside these intervals.
//
// Within a cell the rows leave an interval of accelerations whose ends are a convex and a concave
// function of x, piecewise linear. The x for which it is not empty are found by Newton's method on
// its length, which is concave: from outside it comes up to the zero in finitely many steps and
// never beyond.

#include "time/reachability.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/constants.hpp"

namespace leadthrough {

namespace {

// A row whose gain is smaller than this share of the largest in the grid does not act on u.
constexpr double kNegligibleGain = 1e-9;
// What rounding leaves of a length that is zero, relative to the terms that it is the sum of.
constexpr double kRounding = 1e-12;
constexpr double kSameSpeed = 1e-9;
constexpr int kMostNewtonSteps = 100;

// A bound on u that is linear in x: u <= or >= offset + slope * x.
struct Line {
  double offset, slope;
  double at(double x) const { return offset + slope * x; }
  double size(double x) const { return std::abs(offset) + std::abs(slope) * x; }
};

struct Interval {
  double low, high;
};

class Cell {
 public:
  explicit Cell(Eigen::Index rows) {
    floors_.reserve(static_cast<std::size_t>(2 * rows + 1));
    ceilings_.reserve(static_cast<std::size_t>(2 * rows + 1));
  }

  // Rows of points i and i + 1, and x at i + 1 inside `next`.
  void set(const SpeedBounds& bounds, Eigen::Index i, double least_gain, const Interval& next) {
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
    floors_.push_back({next.low * share, -share});
    ceilings_.push_back({std::min(next.high, bounds.fastest[i + 1]) * share, -share});
  }

  const Line& floor(double x) const {
    const Line* highest = floors_.data();
    double value = highest->at(x);
    for (const Line& line : floors_) {
      const double other = line.at(x);
      if (other > value) {
        value = other;
        highest = &line;
      }
    }
    return *highest;
  }

  const Line& ceiling(double x) const {
    const Line* lowest = ceilings_.data();
    double value = lowest->at(x);
    for (const Line& line : ceilings_) {
      const double other = line.at(x);
      if (other < value) {
        value = other;
        lowest = &line;
      }
    }
    return *lowest;
  }

  // The x that leave an acceleration; low > high where none does.
  Interval controllable() const {
    if (x_.low > x_.high) return x_;
    const double high = outermost(x_.high, x_.low);
    const double low = outermost(x_.low, x_.high);
    // Where one x is left, both come to it but for rounding.
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
    if (gain < 0.0) {
      push(floors_, high);
      push(ceilings_, low);
    } else {
      push(floors_, low);
      push(ceilings_, high);
    }
  }

  static void push(std::vector<Line>& lines, const Line& line) {
    if (std::isfinite(line.offset)) lines.push_back(line);
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
    for (int step = 0; step < kMostNewtonSteps; ++step) {
      const Line &low = floor(x), &high = ceiling(x);
      const double length = high.at(x) - low.at(x);
      if (length >= -kRounding * (low.size(x) + high.size(x))) return x;
      const double slope = high.slope - low.slope;
      if (slope * direction <= 0.0) break;
      const double next = x - length / slope;
      if (next == x) return x;
      x = next;
      if ((x - other) * direction > 0.0) break;
    }
    return direction * kInfinity;
  }

  std::vector<Line> floors_, ceilings_;
  Interval x_{0.0, kInfinity};
};

}  // namespace

void fastest_profile(const SpeedBounds& bounds, double x_start, double x_end,
                     SpeedProfile& profile) {
  const Eigen::Index points = bounds.grid.size();
  const double largest = bounds.gain.size() > 0 ? bounds.gain.cwiseAbs().maxCoeff() : 0.0;
  const double least_gain = kNegligibleGain * largest;
  const auto fail = [&](SpeedStatus status, Eigen::Index i) {
    profile.status = status;
    profile.failed_at = i;
  };
  profile.status = SpeedStatus::kOk;
  profile.failed_at = -1;
  profile.squared.resize(points);
  if (x_end > bounds.fastest[points - 1]) return fail(SpeedStatus::kEndTooFast, points - 1);

  std::vector<Interval> reach(static_cast<std::size_t>(points));
  reach.back() = {x_end, x_end};
  Cell cell(bounds.gain.cols());
  for (Eigen::Index i = points - 2; i >= 0; --i) {
    cell.set(bounds, i, least_gain, reach[static_cast<std::size_t>(i + 1)]);
    const Interval x = cell.controllable();
    if (!(x.low <= x.high)) return fail(SpeedStatus::kNoMotion, i);
    reach[static_cast<std::size_t>(i)] = x;
  }
  if (x_start > reach[0].high * (1.0 + kSameSpeed) || x_start < reach[0].low * (1.0 - kSameSpeed))
    return fail(SpeedStatus::kStartTooFast, 0);

  double x = x_start;
  profile.squared[0] = x;
  for (Eigen::Index i = 0; i + 1 < points; ++i) {
    const Interval& next = reach[static_cast<std::size_t>(i + 1)];
    cell.set(bounds, i, least_gain, next);
    const double length = bounds.grid[i + 1] - bounds.grid[i];
    x = std::clamp(x + 2.0 * length * cell.ceiling(x).at(x), next.low, next.high);
    profile.squared[i + 1] = x;
  }
}

}  // namespace leadthrough
