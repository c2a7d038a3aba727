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

}  // namespace

PlacedShapes placed_shapes(const std::vector<Shape>& shapes) {
  PlacedShapes placed;
  for (const Shape& shape : shapes)
    placed.emplace_back(to_convex(shape), Pose{shape.rotation, shape.position});
  return placed;
}

}  // namespace leadthrough
