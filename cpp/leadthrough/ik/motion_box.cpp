#include "leadthrough/ik/motion_box.hpp"

#include <algorithm>
#include <cmath>

namespace leadthrough {

double braking_speed(double distance, double acceleration, double dt) {
  const double step = acceleration * dt;
  if (!std::isfinite(distance)) return distance;
  if (!std::isfinite(step)) return distance / dt;
  if (!(step > 0.0)) return 0.0;
  // From whole * step the distance is step * dt * whole (whole + 1) / 2; in between it is linear.
  const double intervals = distance / (step * dt);
  const double whole = std::floor(0.5 * (std::sqrt(1.0 + 8.0 * intervals) - 1.0));
  return step * (whole + (intervals - 0.5 * whole * (whole + 1.0)) / (whole + 1.0));
}

MotionBox velocity_box(const MotionLimits& limits, const double* q, const double* qd, double dt) {
  const Eigen::Index n = limits.lower.size();
  MotionBox box{JointVector(n), JointVector(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const double a = limits.acceleration[i], v = limits.velocity[i];
    double lower = -std::min(v, braking_speed(std::max(q[i] - limits.lower[i], 0.0), a, dt));
    double upper = std::min(v, braking_speed(std::max(limits.upper[i] - q[i], 0.0), a, dt));
    if (qd != nullptr) {
      lower = std::clamp(lower, qd[i] - a * dt, qd[i] + a * dt);
      upper = std::clamp(upper, qd[i] - a * dt, qd[i] + a * dt);
    }
    box.lower[i] = lower;
    box.upper[i] = upper;
  }
  return box;
}

MotionBox acceleration_box(const MotionLimits& limits, const double* q, const double* qd,
                           double dt) {
  const Eigen::Map<const Eigen::VectorXd> now(qd, limits.lower.size());
  MotionBox box = velocity_box(limits, q, qd, dt);
  box.lower = (box.lower - now) / dt;
  box.upper = (box.upper - now) / dt;
  return box;
}

}  // namespace leadthrough
