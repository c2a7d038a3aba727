// The time-optimal profile of the reachability pass has jumps in its acceleration. The length that
// it covers by time is averaged over two windows, which bounds the jerk: an acceleration that
// jumps by c becomes a ramp of slope c / width. Averaging moves the motion by a little against its
// path, so that a limit may be exceeded here and there; the profile is then held back, there and
// nowhere else, and computed again. The average is that of the whole profile, not of its samples:
// it has three continuous derivatives, and its own velocities and accelerations are returned.

#include "leadthrough/time/time_law.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/time/limit_use.hpp"
#include "leadthrough/time/profile_clock.hpp"

namespace leadthrough {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

// The length grows at most so many times faster than joints can make it grow: it is what holds a
// motion back where its joints rest.
constexpr double kFastestIdle = 2.0;
// The search for the profile looks at as many samples in the smaller window; the end, at all.
constexpr int kSamplesAWindow = 6;
// An excess is answered by this much more: the search ends sooner, for some 1e-4 of the duration.
constexpr double kAmply = 1.0005;
// Points of the grid over which a hold fades out.
constexpr Index kFade = 8;
constexpr int kMaxCoarseRounds = 8, kRoundsOfPush = 4, kMaxLocalRounds = 16, kMaxSlowRounds = 40,
              kMaxRounds = 60;
// Windows that are too short for any profile grow by this part of them, at least by a sample.
constexpr Index kWidening = 4;
// Excess of a limit that long strides leave to all samples.
constexpr double kCoarseExcess = 1e-3;
// A place is a bottleneck where the motion is so many times slower than on average over the
// windows.
constexpr double kBottleneck = 3.0;
// The bottlenecks are told of a motion that is longer than its profile by so many times its
// windows.
constexpr double kMinDelay = 1.0;
// Points that do not settle are slowed down by this, and by twice as much in every further round.
constexpr double kFirstSlack = 1e-4;

struct Windows {
  Index first, second;  // samples; their sum is even
  Index reach() const { return (first + second) / 2; }
};

class TimeLawSearch {
 public:
  TimeLawSearch(const PolynomialPath& path, const PathGrid& grid, const RateLimits& limits,
                const PathBounds& extra, const TimeLawOptions& options)
      : path_(path),
        grid_(grid),
        limits_(limits),
        extra_(extra),
        options_(options),
        speed_share_(VectorXd::Ones(grid.points())),
        push_share_(VectorXd::Ones(grid.points())) {
    choose_windows();
    prepare_bounds();
  }

  TimeLaw run() {
    TimeLaw law;
    if (search(law)) {
      if (clock_.total() - profile_time_ > kMinDelay * window_time())
        law.bottlenecks = bottlenecks_;
      meet_ends();
      for (const auto& [samples, values] :
           {std::pair(&smooth_.length, &law.length), std::pair(&smooth_.speed, &law.speed),
            std::pair(&smooth_.push, &law.push)})
        *values = Eigen::Map<const VectorXd>(samples->data(), static_cast<Index>(samples->size()));
      law.duration = duration_;
    }
    if (law.status == TimeLawStatus::kNotSettled || law.status == TimeLawStatus::kSlowProfile)
      law.bottlenecks = bottlenecks_;
    law.rounds = rounds_;
    return law;
  }

 private:
  bool rests_at_start() const { return options_.start_speed == 0.0; }
  bool rests_at_end() const { return options_.end_speed == 0.0; }

  // Rest is rest, without rounding; a motion that passes its end has a last sample there.
  void meet_ends() {
    if (rests_at_start()) smooth_.speed.front() = smooth_.push.front() = 0.0;
    if (rests_at_end()) {
      smooth_.speed.back() = smooth_.push.back() = 0.0;
      return;
    }
    smooth_.length.push_back(grid_.end());
    smooth_.speed.push_back(options_.end_speed);
    smooth_.push.push_back(0.0);
  }

  // As long as the joints need from rest to full acceleration, or to full speed if that is less.
  void choose_windows() {
    double width = 0.0;
    for (Index j = 0; j < path_.joints(); ++j) {
      const double jerk = limits_.jerk[j];
      if (jerk > 0.0 && grid_.scale[j] > 0.0)
        width = std::max(
            width, std::min(limits_.acceleration[j] / jerk, std::sqrt(grid_.scale[j] / jerk)));
    }
    const double second = 0.5 * width / options_.period;
    stride_ = std::max<Index>(1, static_cast<Index>(second / kSamplesAWindow));
    const double coarse = options_.period * static_cast<double>(stride_);
    windows_.first = std::max<Index>(1, static_cast<Index>(std::ceil(width / coarse - 1e-6)));
    windows_.second =
        std::max<Index>(1, static_cast<Index>(std::ceil(0.5 * width / coarse - 1e-6)));
    windows_.second += (windows_.first + windows_.second) % 2;
  }

  // A motion that is shorter than its windows hardly feels a slower profile.
  void widen_windows() {
    windows_.first += 1 + windows_.first / kWidening;
    windows_.second += 1 + windows_.second / kWidening;
    windows_.second += (windows_.first + windows_.second) % 2;
  }

  void prepare_bounds() {
    const Index points = grid_.points(), joints = path_.joints();
    const Index rows = joints + extra_.gain.cols() + 1;
    bounds_.grid = grid_.length;
    bounds_.fastest = VectorXd::Constant(points, -1.0);
    used_share_ = bounds_.fastest;
    changed_.resize(static_cast<std::size_t>(points));
    for (Rows* table : {&bounds_.gain, &bounds_.bend, &bounds_.lower, &bounds_.upper})
      table->resize(points, rows);
    bounds_.gain << grid_.first, extra_.gain, VectorXd::Ones(points);
    bounds_.bend << grid_.second, extra_.bend, VectorXd::Zero(points);
    bounds_.lower.rightCols(rows - joints) << extra_.lower, VectorXd::Constant(points, -kInfinity);
    bounds_.upper.rightCols(rows - joints) << extra_.upper, VectorXd::Constant(points, kInfinity);
    hold_ends();

    const double idle = kFastestIdle * kFastestIdle * static_cast<double>(joints);
    fastest_ = extra_.fastest.cwiseMin(idle);
    for (Index i = 0; i < points; ++i)
      for (Index j = 0; j < joints; ++j) {
        const double slope = std::abs(grid_.first(i, j));
        if (limits_.velocity[j] == 0.0) continue;  // does not move
        const double speed = limits_.velocity[j] / slope;
        fastest_[i] = std::min(fastest_[i], speed * speed);
      }
  }

  // Averaging keeps a motion of constant speed: with a speed given, an end is passed at it for as
  // long as the windows reach.
  void hold_ends() {
    const double time = options_.period * static_cast<double>(stride_ * windows_.reach());
    const Index row = bounds_.gain.cols() - 1;
    for (Index i = 0; i < grid_.points(); ++i) {
      const bool start = grid_.length[i] < options_.start_speed * time;
      const bool end = grid_.end() - grid_.length[i] < options_.end_speed * time;
      if (start || end) bounds_.lower(i, row) = bounds_.upper(i, row) = 0.0;
    }
  }

  // Profile, samples and their ratios, `stride` periods apart.
  bool round(Index stride, TimeLaw& law) {
    ++rounds_;
    hold_back_bounds();
    const double start = options_.start_speed, end = options_.end_speed;
    fastest_profile(bounds_, start * start, end * end, profile_, changed_);
    if (profile_.status != SpeedStatus::kOk) return fail(law, profile_.status);
    const double period = options_.period * static_cast<double>(stride);
    clock_ = ProfileClock(grid_, profile_);
    if (rounds_ == 1) law.optimum = clock_.total();
    if (rounds_ == 1 || capped_) find_bottlenecks();
    capped_ = false;
    if (!bottlenecks_.empty() && delay() > options_.most_delay)
      return fail(law, TimeLawStatus::kSlowProfile, -1);
    if (!(clock_.total() + window_time() < options_.longest * options_.period))
      return fail(law, TimeLawStatus::kTooLong, grid_.points() - 1);
    LawSamples before;
    std::swap(before, smooth_);
    sample(period, windows_.first * (stride_ / stride), windows_.second * (stride_ / stride));
    const bool all = stride == 1;
    const Index parts = all ? options_.parts : 1;
    const std::size_t same = stride == sampled_ ? smooth_.same_as(before) : 0;
    measure_use(path_, grid_, limits_, smooth_,
                {period, parts, all, rests_at_start(), rests_at_end()}, same, ratios_);
    sampled_ = stride;
    return true;
  }

  // The bounds of the profile, and at which points they are others than in the round before.
  void hold_back_bounds() {
    const VectorXd fastest =
        fastest_.cwiseProduct(speed_share_.cwiseAbs2()) * (slowness_ * slowness_);
    for (Index i = 0; i < grid_.points(); ++i) {
      const double share = push_share_[i] * slowness_ * slowness_;
      const bool other = fastest[i] != bounds_.fastest[i] || share != used_share_[i];
      changed_[static_cast<std::size_t>(i)] = other ? 1 : 0;
      if (!other) continue;
      bounds_.fastest[i] = fastest[i];
      used_share_[i] = share;
      for (Index j = 0; j < path_.joints(); ++j) {
        const double a =
            limits_.acceleration[j] > 0.0 ? share * limits_.acceleration[j] : kInfinity;
        bounds_.lower(i, j) = -a;
        bounds_.upper(i, j) = a;
      }
    }
  }

  bool fail(TimeLaw& law, SpeedStatus status) {
    constexpr std::array<TimeLawStatus, 4> meaning{TimeLawStatus::kOk, TimeLawStatus::kNoMotion,
                                                   TimeLawStatus::kStartTooFast,
                                                   TimeLawStatus::kEndTooFast};
    return fail(law, meaning[static_cast<std::size_t>(status)], profile_.failed_at);
  }

  static bool fail(TimeLaw& law, TimeLawStatus status, Index at) {
    law.status = status;
    law.failed_at = at;
    return false;
  }

  // Holds the profile back where samples exceed a limit: those of long strides until little is
  // left, then all of them until none does.
  bool search(TimeLaw& law) {
    Index stride = stride_;
    for (int k = 0; k < kMaxRounds; ++k) {
      check_interrupt();
      if (!round(stride, law)) return false;
      if (stride == 1 && excess() == 0.0) return true;
      if (k == 0 && cap_by_jerk()) {
        capped_ = true;
        continue;
      }
      const bool near = excess() <= 1.0 + kCoarseExcess || k + 1 >= kMaxCoarseRounds;
      if (stride > 1 && near) {
        stride = 1;
      } else if (k < kMaxLocalRounds) {
        hold_back((stride_ / stride) * windows_.reach() + options_.parts, k >= kRoundsOfPush);
      } else {
        slow_down(k - kMaxSlowRounds);
      }
    }
    return fail(law, TimeLawStatus::kNotSettled, -1);
  }

  // From rest to rest all settles: jerks fall with the third power of the slowness.
  void slow_down(int insistence) {
    const double factor = excess() * (1.0 + kAllowedExcess);
    slowness_ /= insistence < 0 ? factor : factor * (1.0 + std::ldexp(kFirstSlack, insistence));
    if (insistence >= 0 && clock_.total() < window_time()) widen_windows();
  }

  // The factor on time that the worst ratio asks for.
  double excess() const {
    return std::max(
        {ratios_.largest[0], std::sqrt(ratios_.largest[1]), std::cbrt(ratios_.largest[2])});
  }

  // At a steady speed v of the length a joint's jerk is q''' v^3. Whether the profile was faster
  // than that allows: on short and twisty paths it is, and holding it back alone ends far too slow.
  bool cap_by_jerk() {
    if (!rests_at_start() || !rests_at_end()) return false;  // moving ends may be faster
    bool faster = false;
    for (Index i = 1; i + 1 < grid_.points(); ++i) {
      const double span = grid_.length[i + 1] - grid_.length[i - 1];
      double most = 0.0;  // of a third derivative, in limits of jerk
      for (Index j = 0; j < path_.joints(); ++j) {
        const double third = std::abs(grid_.second(i + 1, j) - grid_.second(i - 1, j)) / span;
        if (limits_.jerk[j] > 0.0) most = std::max(most, third / limits_.jerk[j]);
      }
      if (most == 0.0) continue;  // straight on
      const double speed = std::cbrt(1.0 / most);
      faster = faster || profile_.squared[i] > speed * speed;
      fastest_[i] = std::min(fastest_[i], speed * speed);
    }
    return faster;
  }

  // Every excess counts for the samples that its windows reach. Less acceleration cures it, or
  // less speed where that did not.
  void hold_back(Index reach, bool slow_down) {
    VectorXd speed = VectorXd::Ones(grid_.points()), push = speed;
    for (std::size_t order = 1; order <= 3; ++order) {
      VectorXd& share = order == 1 ? speed : push;
      const auto& each = ratios_.each[order - 1];
      for (std::size_t k = 0; k < each.size(); ++k)
        if (each[k] > 1.0) raise(share, kAmply * each[k], static_cast<Index>(k), reach);
    }
    speed_share_ = speed_share_.cwiseQuotient(speed);
    push_share_ = push_share_.cwiseQuotient(push);
    if (!slow_down) return;
    for (Index i = 0; i < grid_.points(); ++i)
      if (push[i] > 1.0) fastest_[i] = std::min(fastest_[i], profile_.squared[i] / push[i]);
  }

  void raise(VectorXd& share, double ratio, Index sample, Index reach) const {
    const Index last = static_cast<Index>(smooth_.size()) - 1;
    const auto at = [&](Index k) {
      return smooth_.length[static_cast<std::size_t>(std::clamp<Index>(k, 0, last))];
    };
    const double* begin = grid_.length.data();
    const double* end = begin + grid_.points();
    const Index low = std::lower_bound(begin, end, at(sample - reach)) - begin;
    const Index high = std::upper_bound(begin, end, at(sample + reach)) - begin;
    // Fading out on both sides: an edge would be a jump of the acceleration itself.
    for (Index i = std::max<Index>(low - kFade, 0); i < std::min(high + kFade, grid_.points());
         ++i) {
      const double outside = static_cast<double>(std::max({low - i, i - high, Index{0}}));
      const double part = 1.0 - outside / static_cast<double>(kFade);
      share[i] = std::max(share[i], 1.0 + (ratio - 1.0) * part);
    }
  }

  // By how many times both the motion is longer than its first profile and the windows.
  double delay() const {
    const double least = profile_time_ + window_time();
    return clock_.total() / least - 1.0;
  }

  double window_time() const {
    return options_.period * static_cast<double>(stride_ * (windows_.first + windows_.second));
  }

  // Averaging cannot slow a motion down for less time than its windows: around a place that has to
  // be passed slowly all is slowed down.
  void find_bottlenecks() {
    profile_time_ = clock_.total();
    bottlenecks_.clear();
    const VectorXd& x = profile_.squared;
    const double half = 0.5 * window_time();
    Index before = 0, after = 0;
    for (Index i = 1; i + 1 < grid_.points(); ++i) {
      if (x[i] > x[i - 1] || x[i] >= x[i + 1]) continue;
      const double time = clock_.time(i);
      const double from = std::max(time - half, 0.0), to = std::min(time + half, clock_.total());
      const double mean =
          (clock_.length_at(to, after) - clock_.length_at(from, before)) / (to - from);
      if (mean > kBottleneck * std::sqrt(x[i])) bottlenecks_.push_back(i);
    }
  }

  // The profile's length by time, averaged. A motion that rests at an end begins before it, or ends
  // after it, by as much as the windows reach; one that moves there goes on beyond it.
  void sample(double period, Index first, Index second) {
    const double total = clock_.total(), steps = total / period;
    const Index reach = (first + second) / 2;
    const Index begin = rests_at_start() ? -reach : 0;
    const Index end = rests_at_end() ? static_cast<Index>(std::ceil(steps - 1e-9)) + reach
                                     : static_cast<Index>(std::floor(steps - 0.5));
    smooth_ = clock_.smoothed(period, begin - (reach - 1), end - begin + 2 * reach - 1);
    for (std::vector<double>* values : {&smooth_.length, &smooth_.speed, &smooth_.push}) {
      average(*values, first);
      average(*values, second);
    }
    duration_ = rests_at_end() ? static_cast<double>(end - begin) * period
                               : total - static_cast<double>(begin) * period;
  }

  const PolynomialPath& path_;
  const PathGrid& grid_;
  const RateLimits& limits_;
  const PathBounds& extra_;
  const TimeLawOptions options_;
  Windows windows_{};
  Index stride_ = 1, sampled_ = 0;  // the second by the round before
  SpeedBounds bounds_;
  VectorXd fastest_, speed_share_, push_share_, used_share_;
  std::vector<char> changed_;  // see hold_back_bounds
  double slowness_ = 1.0, duration_ = 0.0, profile_time_ = 0.0;
  bool capped_ = false;  // whether the next profile is the first below the caps of jerk
  int rounds_ = 0;
  std::vector<Index> bottlenecks_;
  SpeedProfile profile_;
  LimitRatios ratios_;
  ProfileClock clock_;
  LawSamples smooth_;
};

}  // namespace

TimeLaw make_time_law(const PolynomialPath& path, const PathGrid& grid, const RateLimits& limits,
                      const PathBounds& bounds, const TimeLawOptions& options) {
  for (const Eigen::VectorXd* each : {&limits.velocity, &limits.acceleration, &limits.jerk})
    check_argument(each->size() == path.joints(), "limits: expected one value a joint");
  check_argument(bounds.fastest.size() == grid.points(), "fastest: expected one for each point");
  for (const Rows* table : {&bounds.gain, &bounds.bend, &bounds.lower, &bounds.upper})
    check_argument(table->rows() == grid.points() && table->cols() == bounds.gain.cols(),
                   "bounds: expected one row for each point, one column a bound");
  check_argument(options.parts > 0 && options.parts <= kMaxGridPoints,
                 "parts: expected 1 to kMaxGridPoints");
  return TimeLawSearch(path, grid, limits, bounds, options).run();
}

MotionStates states_along(const PolynomialPath& path, const PathGrid& grid, const VectorRef& length,
                          const VectorRef& speed, const VectorRef& push) {
  const Index samples = length.size(), joints = path.joints();
  check_argument(speed.size() == samples && push.size() == samples,
                 "speed, push: expected one for each length");
  MotionStates result{Rows(samples, joints), Rows(samples, joints), Rows(samples, joints)};
  PathStates states(path, grid);
  for (Index k = 0; k < samples; ++k) {
    check_interrupt(k);
    states.move_to(length[k], speed[k], push[k]);
    result.positions.row(k) = states.position();
    result.velocities.row(k) = states.velocity();
    result.accelerations.row(k) = states.acceleration();
  }
  return result;
}

}  // namespace leadthrough
