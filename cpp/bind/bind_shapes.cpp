#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "base/matrix.hpp"
#include "bind/parts.hpp"
#include "collision/signed_distance.hpp"
#include "rotation/so3.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

Eigen::VectorXd distances(const Shape& shape, const Eigen::Ref<const Rows3>& points) {
  const py::gil_scoped_release release;
  Eigen::VectorXd result(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) result[i] = distance_to(shape, points.row(i));
  return result;
}

// A capsule or a cylinder.
template <ShapeKind kind>
Shape round_shape(double radius, double length, const Eigen::Vector3d& position,
                  const Eigen::Vector4d& orientation) {
  return make_shape(kind, {radius, length, 0.0}, so3::to_matrix(orientation), position);
}

Shape hulls_shape(const std::vector<Rows3>& corners, const Eigen::Vector3d& position,
                  const Eigen::Vector4d& orientation) {
  require(!corners.empty());
  for (const Rows3& own : corners) require(own.rows() >= 4);
  return make_hulls(corners, so3::to_matrix(orientation), position);
}

Shape cloud_shape(const Eigen::Ref<const Rows3>& points, double radius,
                  const Eigen::Vector3d& position, const Eigen::Vector4d& orientation) {
  require(points.rows() > 0 && points.rows() <= Cloud::kMostPoints);
  const py::gil_scoped_release release;
  return make_cloud(std::make_shared<const Cloud>(points, radius), so3::to_matrix(orientation),
                    position);
}

}  // namespace

void bind_shapes(py::module_& module) {
  py::class_<Shape>(module, "Shape").def("distances", &distances, py::arg("points").noconvert());
  module.def(
      "box_shape",
      [](const Eigen::Vector3d& size, const Eigen::Vector3d& position,
         const Eigen::Vector4d& orientation) {
        return make_shape(ShapeKind::kBox, size, so3::to_matrix(orientation), position);
      },
      py::arg("size"), py::arg("position"), py::arg("orientation"));
  module.def(
      "sphere_shape",
      [](double radius, const Eigen::Vector3d& position) {
        return make_shape(ShapeKind::kSphere, {radius, 0.0, 0.0}, Eigen::Matrix3d::Identity(),
                          position);
      },
      py::arg("radius"), py::arg("position"));
  module.def("capsule_shape", &round_shape<ShapeKind::kCapsule>, py::arg("radius"),
             py::arg("length"), py::arg("position"), py::arg("orientation"));
  module.def("cylinder_shape", &round_shape<ShapeKind::kCylinder>, py::arg("radius"),
             py::arg("length"), py::arg("position"), py::arg("orientation"));
  module.def("hulls_shape", &hulls_shape, py::arg("corners"), py::arg("position"),
             py::arg("orientation"));
  module.def("cloud_shape", &cloud_shape, py::arg("points").noconvert(), py::arg("radius"),
             py::arg("position"), py::arg("orientation"));
}

}  // namespace leadthrough
