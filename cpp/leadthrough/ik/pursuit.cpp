#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/ik/damped_step.hpp"
#include "leadthrough/ik/pose_descent.hpp"
#include "leadthrough/ik/rate_box.hpp"
#include "leadthrough/ik/tracking.hpp"

namespace leadthrough {

namespace {

// Keeps the damped matrix regular at singularities, (0.1 mm)^2: the box bounds the step.
constexpr double kFloor = 1e-8;

// Around interval k, from sample k - 1 to sample k. The arm rests before the first sample and after
// the last, for as long as the neighbouring interval takes.
Interval interval_before(const VectorRef& times, Eigen::Index k) {
  const Eigen::Index last = times.size() - 1;
  const double duration = times[k] - times[k - 1];
  const double before = k > 1 ? times[k - 1] - times[k - 2] : duration;
  const double final = times[last] - times[last - 1];
  return {duration, 0.5 * (before + duration),
          times[last] - times[k] + 0.5 * duration + 0.5 * final};
}

template <int M>
class Pursuit {
 public:
  Pursuit(const Chain& chain, const PursuitOptions& options, const JointArray& q,
          const IkTarget& first)
      : chain_(chain), options_(options), q_(q) {
    double fastest = 0.0;
    for (std::size_t i = 0; i < count(); ++i) {
      const double limit = options.velocity[static_cast<Eigen::Index>(i)];
      scale_[i] = std::isfinite(limit) && limit > 0.0 ? limit : 1.0;
      fastest = std::max(fastest, scale_[i]);
    }
    for (std::size_t i = 0; i < count(); ++i) scale_[i] /= fastest;
    evaluate(chain_, first, q_.data(), lag_);
  }

  const JointArray& q() const { return q_; }
  // The error against the last target.
  const Task<M>& lag() const { return lag_; }

  void advance(const IkTarget& target, const Interval& interval, const JointArray& posture,
               double share) {
    const JointBox bounds = box(interval);
    const JointArray pull = gentle_pull(posture, share, interval.duration);
    move(catching_up(target, interval.duration), bounds, pull);
    for (std::size_t i = 0; i < count(); ++i) {
      const double before = q_[i];
      const auto k = static_cast<Eigen::Index>(i);
      q_[i] = std::clamp(before + step_[i], chain_.lower[k], chain_.upper[k]);
      velocity_[i] = step_[i] / interval.duration;
    }
    evaluate(chain_, target, q_.data(), lag_);
  }

 private:
  // A joint brakes softly before its position limit, so that the others can take over from it.
  static constexpr double kPartOfBraking = 0.5;

  // The changes of the joints that their limits allow.
  JointBox box(const Interval& interval) const {
    JointBox bounds{};
    for (std::size_t i = 0; i < count(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const JointRates limits{options_.velocity[k], options_.acceleration[k]};
      const Span room{std::min(chain_.lower[k] - q_[i], 0.0),
                      std::max(chain_.upper[k] - q_[i], 0.0)};
      const Span span = allowed_velocities(limits, interval, room, velocity_[i], kPartOfBraking);
      bounds.lower[i] = span.lower * interval.duration;
      bounds.upper[i] = span.upper * interval.duration;
    }
    return bounds;
  }

  // Self-motion is left with a small part of the joints' speed: the path needs the rest.
  JointArray gentle_pull(const JointArray& posture, double share, double duration) const {
    constexpr double kPartOfSpeed = 0.3;
    if (chain_.joints() <= M || share <= 0.0) return {};
    JointArray pull = pull_to(posture, chain_.joints(), q_, share);
    double most = 0.0;  // of the joints' speed limits
    for (std::size_t i = 0; i < count(); ++i)
      most = std::max(
          most, std::abs(pull[i]) / (duration * options_.velocity[static_cast<Eigen::Index>(i)]));
    if (most > kPartOfSpeed)
      for (double& part : pull) part *= kPartOfSpeed / most;
    return pull;
  }

  // The target, moved back by the part of the lag that this sample cannot remove: the joints
  // approach the path as they would approach a wall, or they would overshoot it.
  IkTarget catching_up(const IkTarget& target, double duration) const {
    const double left = 1.0 - closing_share(duration);
    if (left == 0.0) return target;
    IkTarget nearer = target;
    nearer.position -= left * lag_.error.template head<3>();
    if constexpr (M == 6) {
      const Eigen::Vector3d turn = lag_.error.template tail<3>() / kOrientationWeight;
      nearer.rotation = so3::to_matrix(so3::exp(-left * turn)) * *target.rotation;
    }
    return nearer;
  }

  double closing_share(double duration) const {
    constexpr double kPartOfAcceleration = 0.5;  // the path itself needs the rest
    DampedNormal<M> normal(lag_, chain_.joints(), kFloor + options_.damping,
                           [](int) { return true; });
    if (!normal.factorize(0.0)) return 1.0;
    const TaskVector<M> dual = normal.solve(lag_.error);
    double share = 1.0;
    for (std::size_t i = 0; i < count(); ++i) {
      const double distance = std::abs(lag_.columns[i].dot(dual));
      const double acceleration =
          kPartOfAcceleration * options_.acceleration[static_cast<Eigen::Index>(i)];
      // Within this lag one sample suffices.
      if (distance <= 0.5 * acceleration * duration * duration) continue;
      const double most = braking_velocity(distance, acceleration, duration) * duration;
      share = std::min(share, most / distance);
    }
    return share;
  }

  // Gauss-Newton steps inside the bounds while they gain.
  void move(const IkTarget& target, const JointBox& bounds, const JointArray& pull) {
    constexpr int kIterations = 8;
    constexpr double kEnough = 1e-9;  // rad or m of a joint
    const double damping = kFloor + options_.damping;
    for (std::size_t i = 0; i < count(); ++i)
      step_[i] = std::clamp(0.0, bounds.lower[i], bounds.upper[i]);
    JointArray rest = pull;
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      evaluate_moved(target);
      JointBox room;
      for (std::size_t i = 0; i < count(); ++i) {
        task_.columns[i] *= scale_[i];
        room.lower[i] = (bounds.lower[i] - step_[i]) / scale_[i];
        room.upper[i] = (bounds.upper[i] - step_[i]) / scale_[i];
        if (iteration == 0)
          rest[i] = (pull[i] - step_[i]) / scale_[i];
        else
          rest[i] = options_.damping / damping * (pull[i] - step_[i]) / scale_[i];
      }
      const JointArray change = boxed_step(task_, chain_.joints(), damping, rest, room);
      double largest = 0.0;
      for (std::size_t i = 0; i < count(); ++i) {
        step_[i] = std::clamp(step_[i] + scale_[i] * change[i], bounds.lower[i], bounds.upper[i]);
        largest = std::max(largest, scale_[i] * std::abs(change[i]));
      }
      if (largest <= kEnough) break;
    }
  }

  void evaluate_moved(const IkTarget& target) {
    JointArray moved{};
    for (std::size_t i = 0; i < count(); ++i) moved[i] = q_[i] + step_[i];
    evaluate(chain_, target, moved.data(), task_);
  }

  std::size_t count() const { return static_cast<std::size_t>(chain_.joints()); }

  const Chain& chain_;
  const PursuitOptions& options_;
  JointArray q_;
  JointArray scale_{};  // each joint's speed limit over the fastest one's: slow joints move less
  JointArray velocity_{};
  JointArray step_{};
  Task<M> task_, lag_;
};

IkTarget target_at(const TimedPath& path, Eigen::Index k) {
  return target_in_row(path.positions, path.orientations, k);
}

template <int M>
void pursue_path(const Chain& chain, const TimedPath& path, const JointArray& start,
                 const Pull& pull, const PursuitOptions& options, Track& result) {
  if (result.q.rows() == 0) return;
  Pursuit<M> pursuit(chain, options, start, target_at(path, 0));
  JointArray posture{};
  for (Eigen::Index k = 0; k < result.q.rows(); ++k) {
    check_interrupt();
    std::copy_n(pull.postures.row(k).data(), chain.joints(), posture.begin());
    if (k > 0)
      pursuit.advance(target_at(path, k), interval_before(path.times, k), posture, pull.shares[k]);
    std::copy_n(pursuit.q().begin(), chain.joints(), result.q.row(k).data());
    result.position_errors[k] = pursuit.lag().position_error;
    result.orientation_errors[k] = pursuit.lag().orientation_error;
    if (!pursuit.lag().within(options.deviation)) return result.keep(k + 1);
  }
}

}  // namespace

Track pursue(const Chain& chain, const TimedPath& path, const VectorRef& start, const Pull& pull,
             const PursuitOptions& options) {
  const Eigen::Index samples = path.positions.rows();
  check_path(samples, path.orientations, pull, chain);
  check_argument(path.times.size() == samples, "times: expected one for each position");
  check_argument(
      options.velocity.size() == chain.joints() && options.acceleration.size() == chain.joints(),
      "velocity, acceleration: expected one limit a joint");
  Track result{Rows(samples, chain.joints()), Eigen::VectorXd(samples), Eigen::VectorXd(samples)};
  const JointVector inside = project(chain, start);
  JointArray q{};
  std::copy_n(inside.data(), inside.size(), q.begin());
  const auto along = path.orientations.rows() > 0 ? pursue_path<6> : pursue_path<3>;
  along(chain, path, q, pull, options, result);
  return result;
}

}  // namespace leadthrough
