#include "collision/placed_shapes.hpp"

namespace leadthrough {

namespace {

Convex to_convex(const Shape& shape) {
  switch (shape.kind) {
    case ShapeKind::kBox:
      return box(2.0 * shape.half);
    case ShapeKind::kSphere:
      return sphere(shape.radius);
    case ShapeKind::kCylinder:
      return cylinder(shape.radius, 2.0 * shape.half.z());
    default:
      return capsule(shape.radius, 2.0 * shape.half.z());
  }
}

void add_hulls(const Hulls& hulls, const Pose& pose, PlacedShapes& placed) {
  bool piece = false;
  for (const auto& [convex, middle, radius] : hulls) {
    const Eigen::Vector3d position = pose.rotation * middle + pose.position;
    placed.push_back({convex, {pose.rotation, position}, nullptr, piece});
    piece = true;
  }
}

}  // namespace

PlacedShapes placed_shapes(const std::vector<Shape>& shapes) {
  PlacedShapes placed;
  for (const Shape& shape : shapes) {
    const Pose pose{shape.rotation, shape.position};
    if (shape.kind == ShapeKind::kCloud)
      placed.push_back({{}, pose, shape.cloud});
    else if (shape.kind == ShapeKind::kHulls)
      add_hulls(*shape.hulls, pose, placed);
    else
      placed.push_back({to_convex(shape), pose});
  }
  return placed;
}

}  // namespace leadthrough
