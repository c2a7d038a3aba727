#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <variant>

#include "bind/parts.hpp"
#include "leadthrough/arm/run_down.hpp"
#include "leadthrough/base/matrix.hpp"
#include "leadthrough/collision/clearance.hpp"
#include "leadthrough/collision/edges.hpp"
#include "leadthrough/collision/shapes.hpp"
#include "leadthrough/collision/side_by_side.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

Eigen::VectorXd distances(const Shape& shape, const Rows3Ref& points) {
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

Shape cloud_shape(const Rows3Ref& points, double radius, const Eigen::Vector3d& position,
                  const Eigen::Vector4d& orientation) {
  require(points.rows() > 0 && points.rows() <= Cloud::kMaxPoints);
  const Unlocked unlocked;
  return make_cloud(std::make_shared<const Cloud>(points, radius), so3::to_matrix(orientation),
                    position);
}

CollisionModel make_model(const urdf::Robot& robot, const Chain& chain, const std::string& base,
                          const std::string& tip, const std::vector<std::vector<Rows3>>& meshes,
                          const std::vector<Shape>& attached) {
  const auto between = make_chain(robot, base, tip);
  require(std::holds_alternative<Chain>(between) &&
          moving_count(std::get<Chain>(between)) == moving_count(chain));
  const Unlocked unlocked;
  std::vector<MeshParts> parts(meshes.size());
  for (std::size_t i = 0; i < meshes.size(); ++i)
    for (const Rows3& part : meshes[i]) parts[i].emplace_back(part.transpose());
  return make_collision_model(robot, chain, base, tip, parts, placed_shapes(attached));
}

CollisionModel beside(const CollisionModel& left, const CollisionModel& right,
                      const Eigen::Vector3d& position, const Eigen::Vector4d& orientation,
                      bool one_robot, bool shared_object, const std::vector<std::string>& names) {
  require(left.chain.moving + right.chain.moving <= kMaxJoints &&
          static_cast<int>(names.size()) == left.chain.joints() + right.chain.joints());
  const Transform T_left_right{so3::to_matrix(orientation), position};
  return side_by_side(left, right, {T_left_right, one_robot, shared_object}, names);
}

const std::string& name_of(const CollisionModel& model, int body) {
  return model.bodies[static_cast<std::size_t>(body)].name;
}

std::vector<std::pair<std::string, std::string>> pair_names(const CollisionModel& model) {
  std::vector<std::pair<std::string, std::string>> names;
  const auto body = [&](int i) { return model.shapes[static_cast<std::size_t>(i)].body; };
  for (const auto* pairs : {&model.pairs, &model.between_arms}) {
    for (const auto& [a, b] : *pairs) {
      std::pair<std::string, std::string> pair{name_of(model, body(a)), name_of(model, body(b))};
      if (names.empty() || names.back() != pair) names.push_back(std::move(pair));
    }
  }
  return names;
}

std::vector<std::array<std::string, 3>> left_out(const CollisionModel& model) {
  std::vector<std::array<std::string, 3>> names;
  for (const BodyPair& pair : model.left_out)
    names.push_back({name_of(model, pair.a), name_of(model, pair.b),
                     pair.why == LeftOut::kAdjacent ? "adjacent"
                     : pair.why == LeftOut::kAlways ? "always"
                                                    : "never"});
  return names;
}

py::tuple nearest(const CollisionScene& scene, const RowsRef& q, int threads) {
  const auto found = without_gil([&] { return nearest_batch(scene, q, threads); });
  Eigen::Matrix<int, Eigen::Dynamic, 2, Eigen::RowMajor> bodies(q.rows(), 2);
  Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> points(q.rows(), 6);
  for (Eigen::Index i = 0; i < q.rows(); ++i) {
    const Nearest& at = found[static_cast<std::size_t>(i)];
    bodies.row(i) << at.a, at.b;
    points.row(i) << at.on_a.transpose(), at.on_b.transpose();
  }
  return py::make_tuple(column<double>(found, &Nearest::distance), std::move(bodies),
                        std::move(points));
}

py::tuple to_tuple(const ClosestPair& pair) {
  const Nearest& at = pair.nearest;
  return py::make_tuple(pair.sample, at.a, at.b, at.distance, at.on_a, at.on_b);
}

py::tuple check(const CollisionScene& scene, const RowsRef& q, double margin, double tolerance,
                int threads) {
  const MotionReport report =
      without_gil([&] { return check_motion(scene, q, {margin, tolerance, threads}); });
  return py::make_tuple(column<double>(report.samples, &Nearest::distance),
                        to_tuple(report.closest),
                        report.first ? py::object(to_tuple(*report.first)) : py::none());
}

}  // namespace

void bind_collision(py::module_& module) {
  py::class_<Shape>(module, "Shape").def("distances", &distances, "points"_array);
  module.def("primitive_shape", &primitive_shape, "kind"_a, "sizes"_a, "position"_a,
             "orientation"_a);
  module.def("hulls_shape", &hulls_shape, "corners"_a, "position"_a, "orientation"_a);
  module.def("cloud_shape", &cloud_shape, "points"_array, "radius"_a, "position"_a,
             "orientation"_a);

  py::class_<CollisionModel>(module, "CollisionModel")
      .def(py::init(&make_model), "robot"_a, "chain"_a, "base"_a, "tip"_a, "meshes"_a, "attached"_a)
      .def("beside", &beside, "right"_a, "position"_a, "orientation"_a, "one_robot"_a,
           "shared_object"_a, "joint_names"_a)
      .def_readonly("chain", &CollisionModel::chain)
      .def_property_readonly("bodies",
                             [](const CollisionModel& model) { return names_of(model.bodies); })
      .def_property_readonly("pairs", &pair_names)
      .def_property_readonly("left_out", &left_out);

  py::class_<CollisionScene>(module, "CollisionScene")
      .def_readonly("names", &CollisionScene::names);

  module.def("itself", &itself, "model"_a);
  module.def(
      "against",
      [](const CollisionModel& model, const std::vector<Shape>& obstacles) {
        return against(model, placed_shapes(obstacles));
      },
      "model"_a, "obstacles"_a);
  module.def(
      "clear_batch",
      [](const CollisionModel& model, const std::vector<Shape>& obstacles, const RowsRef& q,
         double margin, double self_collision_margin) {
        const Unlocked unlocked;
        return clear_batch(
            whole_arm(model, placed_shapes(obstacles), margin, self_collision_margin), q);
      },
      "model"_a, "obstacles"_a, "q"_array, "margin"_a, "self_collision_margin"_a);
  module.def(
      "clear_edges",
      [](const CollisionModel& model, const std::vector<Shape>& obstacles, const RowsRef& starts,
         const RowsRef& ends, double margin, double self_collision_margin, int threads) {
        const Unlocked unlocked;
        return clear_edges(whole_arm(without_meeting_pairs(model), placed_shapes(obstacles), margin,
                                     self_collision_margin),
                           starts, ends, threads);
      },
      "model"_a, "obstacles"_a, "starts"_array, "ends"_array, "margin"_a, "self_collision_margin"_a,
      "threads"_a);
  module.def("nearest_bodies", &nearest, "scene"_a, "q"_array, "threads"_a);
  module.def("check_motion", &check, "scene"_a, "q"_array, "margin"_a, "tolerance"_a, "threads"_a);
  module.def("longest_step", &longest_step, "scene"_a, "q"_array, Unlocking());
}

}  // namespace leadthrough
