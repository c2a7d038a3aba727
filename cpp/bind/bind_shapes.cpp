#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <string>

#include "bind/parts.hpp"
#include "leadthrough/base/matrix.hpp"
#include "leadthrough/collision/shapes.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

Eigen::VectorXd distances(const Shape& shape, const Eigen::Ref<const Rows3>& points) {
  const Unlocked unlocked;
  Eigen::VectorXd result(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    check_interrupt();
    result[i] = distance_to(shape, points.row(i));
  }
  return result;
}

Shape primitive_shape(const std::string& kind, const Eigen::VectorXd& sizes,
                      const Eigen::Vector3d& position, const Eigen::Vector4d& orientation) {
  const auto body = primitive(kind, sizes);
  require(body.has_value());
  return {so3::to_matrix(orientation), position, *body};
}

Shape hulls_shape(const std::vector<Rows3>& corners, const Eigen::Vector3d& position,
                  const Eigen::Vector4d& orientation) {
  require(!corners.empty());
  for (const Rows3& own : corners) require(own.rows() >= 4);
  return make_hulls(corners, so3::to_matrix(orientation), position);
}

Shape cloud_shape(const Eigen::Ref<const Rows3>& points, double radius,
                  const Eigen::Vector3d& position, const Eigen::Vector4d& orientation) {
  require(points.rows() > 0 && points.rows() <= Cloud::kMaxPoints);
  const Unlocked unlocked;
  return make_cloud(std::make_shared<const Cloud>(points, radius), so3::to_matrix(orientation),
                    position);
}

}  // namespace

void bind_shapes(py::module_& module) {
  py::class_<Shape>(module, "Shape").def("distances", &distances, py::arg("points").noconvert());
  module.def("primitive_shape", &primitive_shape, py::arg("kind"), py::arg("sizes"),
             py::arg("position"), py::arg("orientation"));
  module.def("hulls_shape", &hulls_shape, py::arg("corners"), py::arg("position"),
             py::arg("orientation"));
  module.def("cloud_shape", &cloud_shape, py::arg("points").noconvert(), py::arg("radius"),
             py::arg("position"), py::arg("orientation"));
}

}  // namespace leadthrough
