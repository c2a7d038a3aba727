#include "collision/signed_distance.hpp"

#include <cmath>

namespace leadthrough {

namespace {

// From the origin; where that is no direction, along x: also a drawing's points have that axis, and
// it leads out of a capsule by the shortest way.
SignedDistance from_ball(const Eigen::Vector3d& offset, double radius) {
  const double length = offset.norm();
  const Eigen::Vector3d along_x = Eigen::Vector3d::UnitX();
  return {length - radius, length > 0.0 ? Eigen::Vector3d(offset / length) : along_x};
}

// The nearest point of the box's surface, or of its nearest face from inside.
SignedDistance from_box(const Eigen::Vector3d& point, const Eigen::Vector3d& half) {
  const Eigen::Vector3d nearest = point.cwiseMax(-half).cwiseMin(half);
  const Eigen::Vector3d outside = point - nearest;
  if (outside.squaredNorm() > 0.0) return from_ball(outside, 0.0);
  Eigen::Index axis = 0;
  const double depth = (point.cwiseAbs() - half).maxCoeff(&axis);
  return {depth, (point[axis] < 0.0 ? -1.0 : 1.0) * Eigen::Vector3d::Unit(axis)};
}

SignedDistance from_segment(const Eigen::Vector3d& point, double half, double radius) {
  const double along = std::min(std::max(point.z(), -half), half);
  return from_ball(point - along * Eigen::Vector3d::UnitZ(), radius);
}

// The nearest point of the side or of an end, from inside too; outside of both, of the rim.
SignedDistance from_cylinder(const Eigen::Vector3d& point, double half, double radius) {
  const SignedDistance side = from_ball({point.x(), point.y(), 0.0}, radius);
  const Eigen::Vector3d end = (point.z() < 0.0 ? -1.0 : 1.0) * Eigen::Vector3d::UnitZ();
  const double beyond = std::abs(point.z()) - half;
  if (side.distance > 0.0 && beyond > 0.0)
    return from_ball(side.distance * side.gradient + beyond * end, 0.0);
  return side.distance > beyond ? side : SignedDistance{beyond, end};
}

SignedDistance in_own_frame(const Shape& shape, const Eigen::Vector3d& point) {
  switch (shape.kind) {
    case ShapeKind::kBox:
      return from_box(point, shape.half);
    case ShapeKind::kCylinder:
      return from_cylinder(point, shape.half.z(), shape.radius);
    default:
      return from_segment(point, shape.half.z(), shape.radius);
  }
}

}  // namespace

Shape make_shape(ShapeKind kind, const Eigen::Vector3d& sizes, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& position) {
  if (kind == ShapeKind::kBox) return {kind, rotation, position, 0.5 * sizes, 0.0};
  const double length = kind == ShapeKind::kSphere ? 0.0 : sizes[1];
  return {kind, rotation, position, 0.5 * length * Eigen::Vector3d::UnitZ(), sizes[0]};
}

SignedDistance signed_distance(const Shape& shape, const Eigen::Vector3d& point) {
  const Eigen::Vector3d offset = point - shape.position;
  if (shape.kind == ShapeKind::kSphere) return from_ball(offset, shape.radius);
  const Eigen::Vector3d local = shape.rotation.transpose() * offset;
  SignedDistance answer = in_own_frame(shape, local);
  answer.gradient = (shape.rotation * answer.gradient).eval();
  return answer;
}

}  // namespace leadthrough
