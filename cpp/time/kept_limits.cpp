#include "time/kept_limits.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace leadthrough {

namespace {

using Eigen::Index;

constexpr Index kOrders = 3;
// A position is given to within so many units in the last place.
constexpr double kUlps = 1.0;

// The samples and those of standing still beyond them, as far as differences reach.
class Padded {
 public:
  explicit Padded(const SampledMotion& motion)
      : motion_(motion),
        first_(motion.rests_at_start ? 1 - kOrders : 0),
        last_(motion.times.size() - 1 + (motion.rests_at_end ? kOrders - 1 : 0)) {}

  Index first() const { return first_; }
  Index last() const { return last_; }
  Index sample(Index k) const { return std::clamp<Index>(k, 0, motion_.times.size() - 1); }

  double time(Index k) const {
    const Index n = motion_.times.size();
    if (k < 0) return motion_.times[0] + static_cast<double>(k) * step(1);
    if (k >= n) return motion_.times[n - 1] + static_cast<double>(k - n + 1) * step(n - 1);
    return motion_.times[k];
  }

 private:
  double step(Index k) const { return motion_.times[k] - motion_.times[k - 1]; }

  const SampledMotion& motion_;
  Index first_, last_;
};

class Judge {
 public:
  Judge(const SampledMotion& motion, const RateLimits& limits)
      : limits_{limits.velocity, limits.acceleration, limits.jerk},
        ulps_(kUlps * std::numeric_limits<double>::epsilon() *
              motion.positions.cwiseAbs().colwise().maxCoeff().transpose()) {}

  // rounding: by how much a unit in the last place of a position changes the values.
  void look(Index order, Index sample, const double* values, double rounding) {
    const Eigen::VectorXd& limit = limits_[static_cast<std::size_t>(order - 1)];
    for (Index j = 0; j < limit.size(); ++j) {
      const double value = std::abs(values[j]) - rounding * ulps_[j];
      if (value > worst_.ratio * limit[j]) worst_ = {order, sample, j, value / limit[j]};
    }
  }

  const LimitUse& worst() const { return worst_; }

 private:
  std::array<Eigen::VectorXd, kOrders> limits_;
  Eigen::VectorXd ulps_;
  LimitUse worst_;
};

void look_at_differences(const SampledMotion& motion, Judge& judge) {
  const Index joints = motion.positions.cols();
  const Padded padded(motion);
  // Row k: the last divided difference of order k, times k!.
  Rows last(kOrders, joints);
  Eigen::VectorXd value(joints);
  for (Index k = padded.first(); k <= padded.last(); ++k) {
    const Index known = std::min(k - padded.first(), kOrders);
    const double* position = motion.positions.row(padded.sample(k)).data();
    std::copy(position, position + joints, value.data());
    double rounding = 1.0;
    for (Index order = 1; order <= known; ++order) {
      const double scale = static_cast<double>(order) / (padded.time(k) - padded.time(k - order));
      rounding *= 2.0 * scale;
      for (Index j = 0; j < joints; ++j) {
        const double rise = value[j] - last(order - 1, j);
        last(order - 1, j) = value[j];
        value[j] = rise * scale;
      }
      judge.look(order, padded.sample(k), value.data(), rounding);
    }
    if (known < kOrders) last.row(known) = value.transpose();
  }
}

}  // namespace

LimitUse largest_use(const SampledMotion& motion, const RateLimits& limits) {
  Judge judge(motion, limits);
  if (motion.times.size() < 2) return judge.worst();
  look_at_differences(motion, judge);
  const double rounding = 2.0 / (motion.times[1] - motion.times[0]);
  for (Index k = 0; k < motion.times.size(); ++k) {
    judge.look(1, k, motion.velocities.row(k).data(), rounding);
    judge.look(2, k, motion.accelerations.row(k).data(), rounding * rounding);
  }
  return judge.worst();
}

}  // namespace leadthrough
