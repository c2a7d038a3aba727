#pragma once

// Distance of a point to a shape, negative inside, with its gradient.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "collision/cloud.hpp"
#include "collision/convex_distance.hpp"

namespace leadthrough {

enum class ShapeKind { kBox, kSphere, kCapsule, kCylinder, kHulls, kCloud };

// Convex hulls, each about its middle in the frame of them all, with the ball about that.
struct PlacedHull {
  Convex convex;
  Eigen::Vector3d middle;
  double radius;
};
using Hulls = std::vector<PlacedHull>;

// half: a box's half edges; of a capsule or a cylinder, which lie along their z, half.z is half the
// length; a capsule's is the one between its balls' centres.
struct Shape {
  ShapeKind kind = ShapeKind::kSphere;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
  double radius = 0.0;
  std::shared_ptr<const Hulls> hulls = nullptr;
  std::shared_ptr<const Cloud> cloud = nullptr;
};

struct SignedDistance {
  double distance;
  Eigen::Vector3d gradient;  // unit, away from the shape
};

// sizes: a box's edges; a ball's radius; the radius of a capsule or a cylinder and the length of
// its axis, m.
Shape make_shape(ShapeKind kind, const Eigen::Vector3d& sizes, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& position);

// corners: of each hull at least four that span a volume, in a frame at the pose. The shape's own
// position is the middle of them all.
Shape make_hulls(const std::vector<Rows3>& corners, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& position);

// The points are in a frame at the pose; the shape's own position is their middle.
Shape make_cloud(std::shared_ptr<const Cloud> cloud, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& position);

// Of several hulls or balls, to the one that the point is nearest to or deepest in.
SignedDistance signed_distance(const Shape& shape, const Eigen::Vector3d& point);

// The distance alone, which takes half the time or less.
double distance_to(const Shape& shape, const Eigen::Vector3d& point);

// How far a shape reaches from its position along a unit vector.
double reach_of(const Shape& shape, const Eigen::Vector3d& direction);

}  // namespace leadthrough
