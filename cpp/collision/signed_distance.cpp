#include "collision/signed_distance.hpp"

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

}  // namespace

Shape make_shape(ShapeKind kind, const Eigen::Vector3d& sizes, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& position) {
  if (kind == ShapeKind::kBox) return {kind, rotation, position, 0.5 * sizes, 0.0};
  const double length = kind == ShapeKind::kCapsule ? sizes[1] : 0.0;
  return {kind, rotation, position, 0.5 * length * Eigen::Vector3d::UnitZ(), sizes[0]};
}

SignedDistance signed_distance(const Shape& shape, const Eigen::Vector3d& point) {
  const Eigen::Vector3d offset = point - shape.position;
  if (shape.kind == ShapeKind::kSphere) return from_ball(offset, shape.radius);
  const Eigen::Vector3d local = shape.rotation.transpose() * offset;
  SignedDistance answer = shape.kind == ShapeKind::kBox
                              ? from_box(local, shape.half)
                              : from_segment(local, shape.half.z(), shape.radius);
  answer.gradient = (shape.rotation * answer.gradient).eval();
  return answer;
}

}  // namespace leadthrough
