#include "collision/signed_distance.hpp"

#include <Eigen/Geometry>
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

// From inside a hull the way out is that of its shallowest direction.
SignedDistance from_hulls(const Eigen::Vector3d& point, const Hulls& hulls) {
  const auto at = [](const Eigen::Vector3d& place) {
    return Pose{Eigen::Matrix3d::Identity(), place};
  };
  SignedDistance least{kInfinity, Eigen::Vector3d::UnitX()};
  for (const auto& [hull, middle, radius] : hulls) {
    if ((point - middle).norm() - radius >= least.distance) continue;
    const Separation found = separation(hull, at(middle), sphere(0.0), at(point), least.distance);
    if (found.distance < least.distance) least = {found.distance, found.normal};
  }
  return least;
}

SignedDistance in_own_frame(const Shape& shape, const Eigen::Vector3d& point) {
  switch (shape.kind) {
    case ShapeKind::kBox:
      return from_box(point, shape.half);
    case ShapeKind::kCylinder:
      return from_cylinder(point, shape.half.z(), shape.radius);
    case ShapeKind::kHulls:
      return from_hulls(point, *shape.hulls);
    case ShapeKind::kCloud:
      return from_ball(point - shape.cloud->nearest_to(point), shape.radius);
    default:
      return from_segment(point, shape.half.z(), shape.radius);
  }
}

// Summed as NumPy's einsum does, which computed these distances first: so they keep their bits.
double length(double x, double y, double z) { return std::sqrt(x * x + z * z + y * y); }

double to_box(const Eigen::Vector3d& point, const Eigen::Vector3d& half) {
  const Eigen::Vector3d outside = point.cwiseAbs() - half, beyond = outside.cwiseMax(0.0);
  return length(beyond.x(), beyond.y(), beyond.z()) + std::min(outside.maxCoeff(), 0.0);
}

double to_cylinder(const Eigen::Vector3d& point, double half, double radius) {
  const double side = std::hypot(point.x(), point.y()) - radius;
  const double end = std::abs(point.z()) - half;
  return std::hypot(std::max(side, 0.0), std::max(end, 0.0)) + std::min(std::max(side, end), 0.0);
}

double to_segment(const Eigen::Vector3d& point, double half, double radius) {
  const double along = std::min(std::max(point.z(), -half), half);
  return length(point.x(), point.y(), point.z() - along) - radius;
}

// As seen from a frame that is turned so.
Eigen::Vector3d turned_back(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& v) {
  return v.x() * rotation.row(0) + v.y() * rotation.row(1) + v.z() * rotation.row(2);
}

}  // namespace

Shape make_shape(ShapeKind kind, const Eigen::Vector3d& sizes, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& position) {
  if (kind == ShapeKind::kBox) return {kind, rotation, position, 0.5 * sizes, 0.0};
  const double length = kind == ShapeKind::kSphere ? 0.0 : sizes[1];
  return {kind, rotation, position, 0.5 * length * Eigen::Vector3d::UnitZ(), sizes[0]};
}

Shape make_hulls(const std::vector<Rows3>& corners, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& position) {
  Eigen::AlignedBox3d around;
  for (const Rows3& own : corners)
    for (Eigen::Index i = 0; i < own.rows(); ++i) around.extend(own.row(i).transpose());
  const Eigen::Vector3d middle = around.center();
  Hulls hulls;
  for (const Rows3& own : corners) {
    const Eigen::Vector3d centre =
        0.5 * (own.colwise().minCoeff() + own.colwise().maxCoeff()).transpose();
    const Convex convex = hull(own.transpose().colwise() - centre);
    hulls.push_back({convex, centre - middle, bounding_radius(convex)});
  }
  Shape shape{ShapeKind::kHulls, rotation, rotation * middle + position};
  shape.hulls = std::make_shared<const Hulls>(std::move(hulls));
  return shape;
}

Shape make_cloud(std::shared_ptr<const Cloud> cloud, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& position) {
  Shape shape{ShapeKind::kCloud, rotation, rotation * cloud->middle() + position};
  shape.radius = cloud->radius();
  shape.cloud = std::move(cloud);
  return shape;
}

SignedDistance signed_distance(const Shape& shape, const Eigen::Vector3d& point) {
  const Eigen::Vector3d offset = point - shape.position;
  if (shape.kind == ShapeKind::kSphere) return from_ball(offset, shape.radius);
  const Eigen::Vector3d local = shape.rotation.transpose() * offset;
  SignedDistance answer = in_own_frame(shape, local);
  answer.gradient = (shape.rotation * answer.gradient).eval();
  return answer;
}

double distance_to(const Shape& shape, const Eigen::Vector3d& point) {
  const Eigen::Vector3d offset = point - shape.position;
  switch (shape.kind) {
    case ShapeKind::kSphere:
      return length(offset.x(), offset.y(), offset.z()) - shape.radius;
    case ShapeKind::kBox:
      return to_box(turned_back(shape.rotation, offset), shape.half);
    case ShapeKind::kCylinder:
      return to_cylinder(turned_back(shape.rotation, offset), shape.half.z(), shape.radius);
    case ShapeKind::kCapsule:
      return to_segment(turned_back(shape.rotation, offset), shape.half.z(), shape.radius);
    default:
      return signed_distance(shape, point).distance;
  }
}

double reach_of(const Shape& shape, const Eigen::Vector3d& direction) {
  if (shape.kind == ShapeKind::kSphere) return shape.radius;
  const Eigen::Vector3d local = shape.rotation.transpose() * direction;
  const double along = shape.half.z() * std::abs(local.z());
  switch (shape.kind) {
    case ShapeKind::kBox:
      return shape.half.dot(local.cwiseAbs());
    case ShapeKind::kCylinder:
      return shape.radius * local.head<2>().norm() + along;
    case ShapeKind::kHulls: {
      double most = -kInfinity;
      for (const auto& [hull, middle, radius] : *shape.hulls)
        most = std::max(most, local.dot(middle) + (local.transpose() * *hull.vertices).maxCoeff());
      return most;
    }
    case ShapeKind::kCloud:
      return shape.cloud->reach(local);
    default:
      return shape.radius + along;
  }
}

}  // namespace leadthrough
