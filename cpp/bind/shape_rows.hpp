#pragma once

// Obstacles and attached bodies as Python hands them over.

#include "collision/check.hpp"
#include "rotation/so3.hpp"

namespace leadthrough {

// A shape a row: kind (sphere 0, capsule 1, box 2), three sizes, position, orientation w, x, y, z.
using ShapeRows = Eigen::Matrix<double, Eigen::Dynamic, 11, Eigen::RowMajor>;

inline PlacedShapes to_shapes(const Eigen::Ref<const ShapeRows>& rows) {
  PlacedShapes shapes;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const Eigen::Vector3d size = rows.row(i).segment<3>(1);
    const Pose pose{so3::to_matrix(rows.row(i).tail<4>()), rows.row(i).segment<3>(4)};
    const auto kind = static_cast<int>(rows(i, 0));
    shapes.emplace_back(kind == 0   ? sphere(size[0])
                        : kind == 1 ? capsule(size[0], size[1])
                                    : box(size),
                        pose);
  }
  return shapes;
}

}  // namespace leadthrough
