#pragma once

// The cores of convex bodies, a type each. Dispatch is by std::visit: the compiler reports members
// that a new core lacks. Directions are unit vectors in the core's frame. A core with kClosedForm
// computes distances of points itself; others use convex_distance.hpp.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <variant>

#include "leadthrough/collision/corners.hpp"

namespace leadthrough {

struct SignedDistance {
  double distance;           // m, negative inside
  Eigen::Vector3d gradient;  // unit, away from the shape
};

namespace cores {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A point relative to a core: if `beyond` is positive, `square` is the squared distance; otherwise
// `beyond` is the signed distance.
struct Offset {
  double square;
  double beyond;
};

// Summed in the order of NumPy's einsum, so that distances have the same bits as in NumPy.
inline double length(double x, double y, double z) { return std::sqrt(x * x + z * z + y * y); }

// At the origin the gradient is x: this axis exists in 2D too, and points out of a capsule along a
// shortest path.
inline SignedDistance from_origin(const Vector3d& offset) {
  const double distance = offset.norm();
  return {distance, distance > 0.0 ? Vector3d(offset / distance) : Vector3d(Vector3d::UnitX())};
}

// The origin of the frame.
struct Point {
  static constexpr bool kClosedForm = true;

  Vector3d support(const Vector3d& /*along*/) const { return Vector3d::Zero(); }
  double reach(const Vector3d& /*along*/) const { return 0.0; }
  double bounding_radius() const { return 0.0; }
  double distance(const Vector3d& p) const { return length(p.x(), p.y(), p.z()); }
  SignedDistance signed_distance(const Vector3d& p) const { return from_origin(p); }
  // to_point: from the core to a point, in the frame relative to which `rotation` is the core's
  // orientation; back: the transpose of `rotation`.
  Offset offset(const Vector3d& to_point, const Matrix3d& /*rotation*/,
                const Matrix3d& /*back*/) const {
    return {to_point.squaredNorm(), 1.0};
  }
};

// Along z, from -half to half, m.
struct Segment {
  static constexpr bool kClosedForm = true;
  double half;

  Vector3d support(const Vector3d& along) const {
    return {0.0, 0.0, std::copysign(half, along.z())};
  }
  double reach(const Vector3d& along) const { return half * std::abs(along.z()); }
  double bounding_radius() const { return half; }
  double distance(const Vector3d& p) const { return length(p.x(), p.y(), p.z() - nearest(p.z())); }
  SignedDistance signed_distance(const Vector3d& p) const {
    return from_origin(p - nearest(p.z()) * Vector3d::UnitZ());
  }
  Offset offset(const Vector3d& to_point, const Matrix3d& rotation,
                const Matrix3d& /*back*/) const {
    const Vector3d axis = rotation.col(2);
    return {(to_point - nearest(axis.dot(to_point)) * axis).squaredNorm(), 1.0};
  }

 private:
  double nearest(double z) const { return std::min(std::max(z, -half), half); }
};

// half: of the edges, m.
struct Box {
  static constexpr bool kClosedForm = true;
  Vector3d half;

  Vector3d support(const Vector3d& along) const {
    return {std::copysign(half.x(), along.x()), std::copysign(half.y(), along.y()),
            std::copysign(half.z(), along.z())};
  }
  double reach(const Vector3d& along) const { return half.dot(along.cwiseAbs()); }
  double bounding_radius() const { return half.norm(); }
  double distance(const Vector3d& p) const {
    const Vector3d outside = p.cwiseAbs() - half, beyond = outside.cwiseMax(0.0);
    return length(beyond.x(), beyond.y(), beyond.z()) + std::min(outside.maxCoeff(), 0.0);
  }
  // To the nearest point of the surface; from inside, to the nearest face.
  SignedDistance signed_distance(const Vector3d& p) const {
    const Vector3d nearest = p.cwiseMax(-half).cwiseMin(half);
    const Vector3d outside = p - nearest;
    if (outside.squaredNorm() > 0.0) return from_origin(outside);
    Eigen::Index axis = 0;
    const double depth = (p.cwiseAbs() - half).maxCoeff(&axis);
    return {depth, (p[axis] < 0.0 ? -1.0 : 1.0) * Vector3d::Unit(axis)};
  }
  Offset offset(const Vector3d& to_point, const Matrix3d& /*rotation*/,
                const Matrix3d& back) const {
    const Vector3d out = (back * to_point).cwiseAbs() - half;
    return {out.cwiseMax(0.0).squaredNorm(), out.maxCoeff()};
  }
};

// Along z, from -half to half, m.
struct Cylinder {
  static constexpr bool kClosedForm = true;
  double radius, half;

  Vector3d support(const Vector3d& along) const {
    const double across = std::sqrt(along.x() * along.x() + along.y() * along.y());
    // Along the axis all points of the rim are equally far; any of them is valid.
    const double scale = across > 0.0 ? radius / across : 0.0;
    const double x = across > 0.0 ? scale * along.x() : radius;
    return {x, scale * along.y(), std::copysign(half, along.z())};
  }
  double reach(const Vector3d& along) const {
    return radius * along.head<2>().norm() + half * std::abs(along.z());
  }
  double bounding_radius() const { return std::hypot(radius, half); }
  double distance(const Vector3d& p) const {
    const double side = std::hypot(p.x(), p.y()) - radius;
    const double end = std::abs(p.z()) - half;
    return std::hypot(std::max(side, 0.0), std::max(end, 0.0)) + std::min(std::max(side, end), 0.0);
  }
  // To the nearest point of the side or of an end, from inside too; outside of both, of the rim.
  SignedDistance signed_distance(const Vector3d& p) const {
    const SignedDistance axis = from_origin({p.x(), p.y(), 0.0});
    const double side = axis.distance - radius;
    const Vector3d end = (p.z() < 0.0 ? -1.0 : 1.0) * Vector3d::UnitZ();
    const double beyond = std::abs(p.z()) - half;
    if (side > 0.0 && beyond > 0.0) return from_origin(side * axis.gradient + beyond * end);
    return side > beyond ? SignedDistance{side, axis.gradient} : SignedDistance{beyond, end};
  }
  Offset offset(const Vector3d& to_point, const Matrix3d& rotation,
                const Matrix3d& /*back*/) const {
    const Vector3d axis = rotation.col(2);
    const double along = axis.dot(to_point);
    const double side = (to_point - along * axis).norm() - radius;
    const double end = std::abs(along) - half;
    const double out_side = std::max(side, 0.0), out_end = std::max(end, 0.0);
    return {out_side * out_side + out_end * out_end, std::max(side, end)};
  }
};

// The convex hull of vertices that span a volume, m.
struct Hull {
  static constexpr bool kClosedForm = false;
  std::shared_ptr<const Corners> corners;

  Vector3d support(const Vector3d& along) const { return corners->farthest(along); }
  double reach(const Vector3d& along) const {
    return (along.transpose() * corners->points()).maxCoeff();
  }
  double bounding_radius() const { return corners->points().colwise().norm().maxCoeff(); }
};

}  // namespace cores

using Core = std::variant<cores::Point, cores::Segment, cores::Box, cores::Cylinder, cores::Hull>;

// All points within `rounding` of a core.
struct Convex {
  Core core;
  double rounding = 0.0;  // m
};

inline Convex sphere(double radius) { return {cores::Point{}, radius}; }

// length: between the centres of the end balls.
inline Convex capsule(double radius, double length) {
  return {cores::Segment{0.5 * length}, radius};
}

inline Convex box(const Eigen::Vector3d& size) { return {cores::Box{0.5 * size}}; }

inline Convex cylinder(double radius, double length) {
  return {cores::Cylinder{radius, 0.5 * length}};
}

inline Convex hull(Eigen::Matrix3Xd vertices) {
  return {cores::Hull{std::make_shared<const Corners>(std::move(vertices))}};
}

// The core's farthest point along a direction, in its own frame.
inline Eigen::Vector3d support(const Convex& body, const Eigen::Vector3d& along) {
  return std::visit([&](const auto& core) { return core.support(along); }, body.core);
}

// Radius of the bounding ball about the frame's origin, m.
inline double bounding_radius(const Convex& body) {
  return std::visit([&](const auto& core) { return core.bounding_radius() + body.rounding; },
                    body.core);
}

}  // namespace leadthrough
