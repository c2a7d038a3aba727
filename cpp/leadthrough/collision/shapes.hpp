#pragma once

// Obstacles and attached objects: distances of points, and their parts for collision checks.

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "leadthrough/collision/cloud.hpp"
#include "leadthrough/collision/convex_distance.hpp"

namespace leadthrough {

// A convex hull relative to its middle, given in the shape's frame, and its bounding radius.
struct PlacedHull {
  Convex convex;
  Eigen::Vector3d middle;
  double radius;
};
using Hulls = std::vector<PlacedHull>;

struct Shape {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d position;
  std::variant<Convex, std::shared_ptr<const Hulls>, std::shared_ptr<const Cloud>> body;
};

// The convex body of a kind and its sizes, m, or nothing: a "box" of three edges, a "sphere" of a
// radius, a "capsule" or "cylinder" of a radius and a length.
std::optional<Convex> primitive(std::string_view kind, const Eigen::VectorXd& sizes);

// corners: for each hull at least four that span a volume, in a frame at the pose. The shape's own
// position is the middle of all corners.
Shape make_hulls(const std::vector<Rows3>& corners, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& position);

// The points are in a frame at the pose; the shape's own position is their middle.
Shape make_cloud(std::shared_ptr<const Cloud> cloud, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& position);

// For several hulls or balls, to the one that the point is nearest to or deepest in.
SignedDistance signed_distance(const Shape& shape, const Eigen::Vector3d& point);

// The distance alone, which takes half the time or less.
double distance_to(const Shape& shape, const Eigen::Vector3d& point);

// Extent of a shape from its position along a unit vector, m.
double reach_of(const Shape& shape, const Eigen::Vector3d& direction);

// A convex body or a cloud at its pose. Pieces of one shape are consecutive; `piece` marks all but
// the first.
struct PlacedShape {
  Convex convex;
  Transform pose;
  std::shared_ptr<const Cloud> cloud = nullptr;
  bool piece = false;
};
using PlacedShapes = std::vector<PlacedShape>;

PlacedShapes placed_shapes(const std::vector<Shape>& shapes);

}  // namespace leadthrough
