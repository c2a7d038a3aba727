#pragma once

// Canonical subproblems: rotations about fixed axes that bring points into place. Paden 1986 and
// Kahan 1983, in the form of Elias and Wen 2022, "IK-Geo: Unified robot inverse kinematics using
// subproblem decomposition". Angles are pairs of cosine and sine: no trigonometry here.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace leadthrough {

struct Angle {
  double cosine = 1.0, sine = 0.0;
};

// State of one pass over all branches of a closed form.
struct Walk {
  // Equations that miss a solution by at most this take the tangent point, whose error forward
  // kinematics judges; m, m^2 or unit vectors' products.
  double slack = 0.0;
  // Those that miss one by at most this more take it as well, and `missed` is the sum of such on
  // the way: a branch goes on continuously beyond its ends.
  double reach = 0.0;
  double missed = 0.0;
  double margin = 0.0;  // from a tangency, where `near` is set
  bool near = false;    // an equation was close to losing or gaining a solution
  // Angles that the target leaves free take these values, outermost first. Solutions with another
  // number of free angles than `given` are left out; `free` is the largest number met.
  std::array<Angle, 2> values{};
  int given = 0, depth = 0, free = 0;
  int branch = 1;  // one bit for each choice so far, below a leading 1
};

// Below this, in m or rad, a lever is 0 and the angle free: rounding leaves 1e-8.
constexpr double kNoLever = 2e-7;

inline Eigen::Vector3d rotate(const Eigen::Vector3d& axis, Angle angle, const Eigen::Vector3d& v) {
  return angle.cosine * v + angle.sine * axis.cross(v) +
         ((1.0 - angle.cosine) * axis.dot(v)) * axis;
}

inline Angle opposite(Angle angle) { return {angle.cosine, -angle.sine}; }

inline Eigen::Matrix3d rotation_about(const Eigen::Vector3d& axis, Angle angle) {
  const Eigen::Vector3d scaled = angle.sine * axis;
  Eigen::Matrix3d m = ((1.0 - angle.cosine) * axis) * axis.transpose();
  m.diagonal().array() += angle.cosine;
  m(0, 1) -= scaled[2], m(1, 0) += scaled[2];
  m(2, 0) -= scaled[1], m(0, 2) += scaled[1];
  m(1, 2) -= scaled[0], m(2, 1) += scaled[0];
  return m;
}

// The angle about `axis` from a to b, seen along the axis; {0, 0} without a lever.
inline Angle angle_between(const Eigen::Vector3d& axis, const Eigen::Vector3d& a,
                           const Eigen::Vector3d& b) {
  const auto direction = [](double cosine, double sine) {
    const double length = std::sqrt(cosine * cosine + sine * sine);
    return length < kNoLever * kNoLever ? Angle{0.0, 0.0} : Angle{cosine / length, sine / length};
  };
  const double cosine = a.dot(b) - axis.dot(a) * axis.dot(b), sine = axis.dot(a.cross(b));
  constexpr double kShort = 1e-6;  // levers' product: their difference keeps ten digits
  if (std::abs(cosine) + std::abs(sine) > kShort) return direction(cosine, sine);
  const Eigen::Vector3d from = axis.cross(a), to = axis.cross(b);
  return direction(from.dot(to), axis.dot(from.cross(to)));
}

template <typename Visit>
void visit_free(Walk& walk, const Visit& visit) {
  walk.free = std::max(walk.free, ++walk.depth);
  if (walk.depth <= walk.given) visit(walk.values[static_cast<std::size_t>(walk.depth - 1)]);
  --walk.depth;
}

// Subproblem 1: rotate(axis, angle, a) = b.
template <typename Visit>
void each_rotation(const Eigen::Vector3d& axis, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                   Walk& walk, const Visit& visit) {
  const Angle angle = angle_between(axis, a, b);
  if (walk.margin > 0.0) {
    const Eigen::Vector3d lever = axis.cross(a);
    walk.near = walk.near || lever.squaredNorm() < walk.margin * walk.margin;
  }
  if (angle.cosine == 0.0 && angle.sine == 0.0) return visit_free(walk, visit);
  visit(angle);
}

// a cos + b sin = c: up to two angles.
template <typename Visit>
void each_angle(double a, double b, double c, Walk& walk, const Visit& visit) {
  const double squared = a * a + b * b, radius = std::sqrt(squared);
  walk.near = walk.near || std::abs(radius - std::abs(c)) < walk.margin;
  const double missed = walk.missed, misses = std::abs(c) - radius - walk.slack;
  if (misses > walk.reach) return;
  if (radius < kNoLever) {
    if (misses <= 0.0) visit_free(walk, visit);
    return;
  }
  const double along = std::clamp(c, -radius, radius) / squared;
  const double across = std::sqrt(std::max((radius - c) * (radius + c), 0.0)) / squared;
  const int branch = walk.branch;
  walk.missed += std::max(misses, 0.0);
  for (int k = 0; k < (across > 0.0 ? 2 : 1); ++k) {
    const double side = k == 0 ? across : -across;
    walk.branch = 2 * branch + k;
    visit(Angle{a * along - b * side, b * along + a * side});
  }
  walk.branch = branch, walk.missed = missed;
}

// Subproblem 4: normal . rotate(axis, angle, v) = distance.
template <typename Visit>
void each_projection(const Eigen::Vector3d& axis, const Eigen::Vector3d& v,
                     const Eigen::Vector3d& normal, double distance, Walk& walk,
                     const Visit& visit) {
  const double constant = axis.dot(normal) * axis.dot(v);
  each_angle(normal.dot(v) - constant, normal.dot(axis.cross(v)), distance - constant, walk, visit);
}

}  // namespace leadthrough
