#include "leadthrough/guard/pace.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/guard/bridge.hpp"
#include "leadthrough/guard/path_curve.hpp"

namespace leadthrough::guard {

namespace {

using Eigen::ArrayXd;
using Eigen::Index;

// Rounds in which the pace falls where it is too high; then it falls everywhere.
constexpr int kLocalRounds = 8, kRounds = 24;
// Each round aims slightly below the limit, so that one round usually suffices.
constexpr double kSpare = 1.002;
// A stop takes longer with each attempt by this fraction.
constexpr Index kStopFractions = 8;
// An eased path has at most this many times its rows.
constexpr Index kMaxEase = 4;
// A ramp takes longer with each attempt by this fraction.
constexpr Index kEaseFractions = 2;
// A state that is not that of the path is led onto it in at most this many periods.
constexpr Index kMaxPeriods = 16;

// Periods in which the fastest joint of the path can stop: the time scale of changes of pace.
Index gentle(const StepLimits& limits, const RowsRef& path) {
  double periods = 1.0;
  for (Index j = 0; j < limits.joints(); ++j) {
    double fastest = 0.0;
    for (Index i = 1; i < path.rows(); ++i)
      fastest = std::max(fastest, std::abs(path(i, j) - path(i - 1, j)));
    fastest = std::min(fastest / limits.period, limits.velocity[j]);
    const double time = fastest / limits.acceleration[j] + limits.acceleration[j] / limits.jerk[j];
    periods = std::max(periods, time / limits.period);
  }
  return static_cast<Index>(std::min(std::ceil(periods), static_cast<double>(path.rows()))) + 1;
}

// Periods per row, as their logarithm, raised to `needed` at row i and smoothly less around it.
void raise(ArrayXd& delay, Index i, double needed, Index width) {
  if (needed <= delay[i]) return;
  const Index first = std::max<Index>(0, i - width), end = std::min(delay.size(), i + width + 1);
  for (Index k = first; k < end; ++k) {
    const double off = static_cast<double>(k - i) / static_cast<double>(width + 1);
    delay[k] = std::max(delay[k], needed * 0.5 * (1.0 + std::cos(kPi * off)));
  }
}

// Parameters of samples, a period apart, on a path with these periods per row.
ArrayXd places_for(const ArrayXd& delay, Index most) {
  const Index rows = delay.size();
  ArrayXd time(rows);
  time[0] = 0.0;
  for (Index i = 1; i < rows; ++i)
    time[i] = time[i - 1] + std::exp(0.5 * (delay[i] + delay[i - 1]));
  const double whole = std::max(1.0, std::ceil(time[rows - 1] - 1e-9));
  time *= whole / time[rows - 1];
  const Index count = std::min(static_cast<Index>(std::min(whole, 1e9)) + 1, most);
  ArrayXd places(count);
  Index i = 1;
  for (Index k = 0; k < count; ++k) {
    check_interrupt(k);
    const double t = static_cast<double>(k);
    while (i < rows - 1 && time[i] < t) ++i;
    places[k] =
        static_cast<double>(i - 1) + std::min(1.0, (t - time[i - 1]) / (time[i] - time[i - 1]));
  }
  return places;
}

// Samples whose parameters are a cubic spline of these control points, so that the pace is smooth.
void run_along(const PathCurve& curve, ArrayXd& places, Rows& samples) {
  const Index last = places.size() - 1;
  samples.resize(places.size(), samples.cols());
  const ArrayXd controls = places;
  for (Index k = 0; k <= last; ++k) {
    check_interrupt();
    const double before = controls[std::max<Index>(k - 1, 0)];
    const double after = controls[std::min(k + 1, last)];
    const bool inner = k > 0 && k < last;
    const double bend = inner ? after - 2.0 * controls[k] + before : 0.0;
    places[k] += bend / 6.0;
    curve.at(places[k], inner ? 0.5 * (after - before) : after - before, bend, samples.row(k));
  }
}

class Pacing {
 public:
  Pacing(const StepLimits& limits, const RowsRef& path, Index most_samples)
      : limits_(limits),
        path_(path),
        most_samples_(most_samples),
        curve_(path, limits.period),
        width_(gentle(limits, path)) {}

  // The pace falls where a limit is exceeded for so many rounds, and then everywhere. Nothing if
  // that takes so many samples or more.
  std::optional<Paced> settled(int local_rounds, Index too_many) const {
    ArrayXd delay = ArrayXd::Zero(path_.rows());
    Rows samples(0, path_.cols());
    for (int round = 0; round < kRounds; ++round) {
      check_interrupt();
      ArrayXd places = places_for(delay, most_samples_);
      if (places.size() >= too_many) return std::nullopt;  // the pace only falls
      run_along(curve_, places, samples);
      const Eigen::VectorXd needed = slowdowns(limits_, samples);
      const double worst = needed.maxCoeff();
      if (!std::isfinite(worst)) return std::nullopt;
      if (worst <= 1.0) return Paced{std::move(samples), places.matrix()};
      if (round < local_rounds)
        slow_down(needed, places, delay);
      else
        delay += std::log(worst * kSpare);
    }
    return std::nullopt;
  }

 private:
  void slow_down(const Eigen::VectorXd& needed, const ArrayXd& places, ArrayXd& delay) const {
    const ArrayXd now = delay;
    for (Index k = 0; k < needed.size(); ++k) {
      if (needed[k] <= 1.0) continue;
      const auto i = static_cast<Index>(std::lround(places[k]));
      raise(delay, i, now[i] + std::log(needed[k] * kSpare), width_);
    }
  }

  const StepLimits& limits_;
  const RowsRef& path_;
  Index most_samples_;
  PathCurve curve_;
  Index width_;
};

}  // namespace

std::optional<Paced> slowed(const StepLimits& limits, const RowsRef& path, Index most_samples) {
  check_states(limits, path, 1);
  check_argument(most_samples > 0 && most_samples <= kMaxPaced,
                 "most_samples: expected 1 to kMaxPaced");
  if (path.rows() == 1) return Paced{path, Eigen::VectorXd::Zero(1)};
  const Pacing pacing(limits, path, most_samples);
  std::optional<Paced> local = pacing.settled(kLocalRounds, kMaxPaced + 1);
  if (local && local->places.size() == path.rows()) return local;
  std::optional<Paced> even = pacing.settled(0, local ? local->places.size() : kMaxPaced + 1);
  return even ? even : local;
}

std::optional<Paced> stopped(const StepLimits& limits, const RowsRef& start, const RowsRef& path) {
  check_start(limits, start);
  check_states(limits, path, 1);
  Rows rows(1 + path.rows(), path.cols());
  rows << start, path;
  const PathCurve curve(rows, limits.period);
  Rows stream(2 * path.rows() + 3, path.cols());
  stream.topRows(rows.rows()) = rows;
  ArrayXd places(stream.rows());
  for (Index stop = 2; stop / 2 < path.rows(); stop += 1 + stop / kStopFractions) {
    check_interrupt();
    // The pace falls from 1 to 0 as 1 - 3 s^2 + 2 s^3, in half as many rows as periods. Attempts
    // that are too short end within a few rows, and those after them begin at the same row or
    // before.
    const Index first = path.rows() - 1 - stop / 2;
    bool satisfied = true;
    for (Index k = 1; satisfied && k <= stop; ++k) {
      check_interrupt();
      const double s = static_cast<double>(k) / static_cast<double>(stop);
      const double gone = static_cast<double>(stop) * s * (1.0 - s * s * (1.0 - 0.5 * s));
      const double rate = k < stop ? 1.0 - s * s * (3.0 - 2.0 * s) : 0.0;
      const double bend = -6.0 * s * (1.0 - s) / static_cast<double>(stop);
      const Index row = first + k;
      places[row - 1] = static_cast<double>(first - 1) + gone;
      curve.at(1.0 + places[row - 1], rate, bend, stream.row(row));
      satisfied = keeps(limits, stream, row);
    }
    if (!satisfied) continue;
    for (Index k = 0; k < first; ++k) places[k] = static_cast<double>(k);
    const Index count = first + stop;
    return Paced{stream.middleRows(1, count), places.head(count).matrix()};
  }
  return std::nullopt;
}

namespace {

// A pace from `before` to `after` rows a period over `ramp` periods, as 3 u^2 - 2 u^3.
struct Ramp {
  double before, after, ramp;

  struct At {
    double place, rate, bend;
  };
  At at(double k) const {
    const double u = std::min(1.0, k / ramp), change = after - before;
    const double gone = ramp * u * u * u * (1.0 - 0.5 * u) + std::max(0.0, k - ramp);
    return {before * k + change * gone, before + change * u * u * (3.0 - 2.0 * u),
            change * 6.0 * u * (1.0 - u) / ramp};
  }
};

// The pace along a path of a state at its first row.
double pace_of(const RowsRef& start, const RowsRef& path, double at_rest) {
  const Index joints = path.cols() / 3;
  const auto along = path.row(0).segment(joints, joints);
  const double size = along.squaredNorm();
  if (!(size > 0.0)) return at_rest;
  return std::clamp(start.row(0).segment(joints, joints).dot(along) / size, 0.0, 1.0);
}

}  // namespace

std::optional<Paced> eased(const StepLimits& limits, const RowsRef& start, const RowsRef& path,
                           double rate) {
  check_start(limits, start);
  check_states(limits, path, 1);
  check_argument(rate > 0.0, "rate: expected a positive one");
  if (path.rows() < 2) return std::nullopt;
  const PathCurve curve(path, limits.period);
  const double before = pace_of(start, path, rate);
  const double last = static_cast<double>(path.rows() - 1);
  const Index most = kMaxEase * path.rows();
  Rows stream(most + 1, path.cols());
  stream.row(0) = start.row(0);
  ArrayXd places(most);
  for (Index ramp = 1; ramp < most; ramp += 1 + ramp / kEaseFractions) {
    check_interrupt();
    const Ramp law{before, rate, static_cast<double>(ramp)};
    // Rows from `first` to `end` that keep the limits, those of the path's end or of an excess left
    // out.
    const auto filled = [&](Index first, Index end) {
      for (Index k = first; k < end; ++k) {
        const Ramp::At now = law.at(static_cast<double>(k));
        if (now.place > last) return k;
        places[k - 1] = now.place;
        curve.at(now.place, now.rate, now.bend, stream.row(k));
        if (k > 1 && !keeps(limits, stream, k)) return k;
      }
      return end;
    };
    const Index begun = std::min(ramp + 1 + kMaxPeriods, most + 1);
    const Index known = filled(1, begun);
    if (known <= std::min(ramp, begun - 1)) continue;
    const auto onto = bridge_on_time(limits, start, stream.middleRows(1, known - 1), kMaxPeriods);
    if (!onto) continue;
    stream.middleRows(1, onto->skipped) = onto->samples;
    const Index count = (known < begun ? known : filled(begun, most + 1)) - 1;
    return Paced{stream.middleRows(1, count), places.head(count).matrix()};
  }
  return std::nullopt;
}

}  // namespace leadthrough::guard
