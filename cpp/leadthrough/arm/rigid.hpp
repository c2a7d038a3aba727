#pragma once

// Rigid bodies: their sum, and in another frame.

#include "leadthrough/arm/urdf.hpp"

namespace leadthrough {

// A body given in frame b, in frame a.
inline urdf::Inertia operator*(const Transform& T_a_b, const urdf::Inertia& body) {
  return {body.mass, T_a_b.rotation * body.center + T_a_b.position,
          T_a_b.rotation * body.moments * T_a_b.rotation.transpose()};
}

// Moments about `point` beyond those about the body's centre, by the parallel axis theorem.
inline Eigen::Matrix3d moments_of_offset(const urdf::Inertia& body, const Eigen::Vector3d& point) {
  const Eigen::Vector3d offset = body.center - point;
  return body.mass *
         (offset.squaredNorm() * Eigen::Matrix3d::Identity() - offset * offset.transpose());
}

// Sum of two bodies in the same frame.
inline urdf::Inertia operator+(const urdf::Inertia& a, const urdf::Inertia& b) {
  const double mass = a.mass + b.mass;
  if (mass == 0.0) return {0.0, Eigen::Vector3d::Zero(), a.moments + b.moments};
  const Eigen::Vector3d center = (a.mass / mass) * a.center + (b.mass / mass) * b.center;
  return {mass, center,
          a.moments + b.moments + moments_of_offset(a, center) + moments_of_offset(b, center)};
}

}  // namespace leadthrough
