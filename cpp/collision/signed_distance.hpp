#pragma once

// Distance of a point to convex primitives, negative inside, with its gradient.

#include <Eigen/Core>

namespace leadthrough {

enum class ShapeKind { kBox, kSphere, kCapsule, kCylinder };

// half: a box's half edges; of a capsule or a cylinder, which lie along their z, half.z is half the
// length; a capsule's is the one between its balls' centres.
struct Shape {
  ShapeKind kind = ShapeKind::kSphere;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
  double radius = 0.0;
};

struct SignedDistance {
  double distance;
  Eigen::Vector3d gradient;  // unit, away from the shape
};

// sizes: a box's edges; a ball's radius; the radius of a capsule or a cylinder and the length of
// its axis, m.
Shape make_shape(ShapeKind kind, const Eigen::Vector3d& sizes, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& position);

SignedDistance signed_distance(const Shape& shape, const Eigen::Vector3d& point);

}  // namespace leadthrough
