#include "leadthrough/signed_distance.hpp"

namespace leadthrough {

namespace {

// From the origin; where that is no direction, up.
SignedDistance from_ball(const Eigen::Vector3d& offset, double radius) {
  const double length = offset.norm();
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  return {length - radius, length > 0.0 ? Eigen::Vector3d(offset / length) : up};
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

SignedDistance signed_distance(const Shape& shape, const Eigen::Vector3d& point) {
  const Eigen::Vector3d local = shape.rotation.transpose() * (point - shape.position);
  SignedDistance answer = shape.kind == ShapeKind::kBox ? from_box(local, shape.half)
                          : shape.kind == ShapeKind::kSphere
                              ? from_ball(local, shape.radius)
                              : from_segment(local, shape.half.z(), shape.radius);
  answer.gradient = (shape.rotation * answer.gradient).eval();
  return answer;
}

}  // namespace leadthrough
