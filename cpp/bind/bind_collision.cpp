#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <utility>
#include <variant>

#include "bind/parts.hpp"
#include "leadthrough/arm/run_down.hpp"
#include "leadthrough/collision/clearance.hpp"
#include "leadthrough/collision/edges.hpp"
#include "leadthrough/collision/shapes.hpp"
#include "leadthrough/collision/side_by_side.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using Pairs = Eigen::Matrix<int, Eigen::Dynamic, 2, Eigen::RowMajor>;
using Points = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;

CollisionModel make_model(const urdf::Robot& robot, const Chain& chain, const std::string& base,
                          const std::string& tip, const std::vector<std::vector<Rows3>>& meshes,
                          const std::vector<Shape>& attached) {
  std::size_t asked = 0;
  for (const urdf::Link& link : robot.links)
    for (const urdf::Geometry& collision : link.collisions)
      asked += collision.type == urdf::GeometryType::kMesh ? 1 : 0;
  require(meshes.size() == asked);
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

std::vector<std::string> body_names(const CollisionModel& model) {
  std::vector<std::string> names;
  for (const Body& body : model.bodies) names.push_back(body.name);
  return names;
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

py::tuple nearest(const CollisionScene& scene, const Eigen::Ref<const Rows>& q, int threads) {
  Eigen::VectorXd distances(q.rows());
  Pairs bodies(q.rows(), 2);
  Points points(q.rows(), 6);
  {
    const Unlocked unlocked;
    const auto found = nearest_batch(scene, q, threads);
    for (Eigen::Index i = 0; i < q.rows(); ++i) {
      const Nearest& at = found[static_cast<std::size_t>(i)];
      distances[i] = at.distance;
      bodies.row(i) << at.a, at.b;
      points.row(i) << at.on_a.transpose(), at.on_b.transpose();
    }
  }
  return py::make_tuple(std::move(distances), std::move(bodies), std::move(points));
}

py::tuple to_tuple(const ClosestPair& pair) {
  const Nearest& at = pair.nearest;
  return py::make_tuple(pair.sample, at.a, at.b, at.distance, at.on_a, at.on_b);
}

py::tuple check(const CollisionScene& scene, const Eigen::Ref<const Rows>& q, double margin,
                double tolerance, int threads) {
  MotionReport report;
  Eigen::VectorXd distances(q.rows());
  {
    const Unlocked unlocked;
    report = check_motion(scene, q, {margin, tolerance, threads});
    for (Eigen::Index i = 0; i < q.rows(); ++i)
      distances[i] = report.samples[static_cast<std::size_t>(i)].distance;
  }
  return py::make_tuple(std::move(distances), to_tuple(report.closest),
                        report.first ? py::object(to_tuple(*report.first)) : py::none());
}

}  // namespace

void bind_collision(py::module_& module) {
  py::class_<CollisionModel>(module, "CollisionModel")
      .def(py::init(&make_model), py::arg("robot"), py::arg("chain"), py::arg("base"),
           py::arg("tip"), py::arg("meshes"), py::arg("attached"))
      .def("beside", &beside, py::arg("right"), py::arg("position"), py::arg("orientation"),
           py::arg("one_robot"), py::arg("shared_object"), py::arg("joint_names"))
      .def_readonly("chain", &CollisionModel::chain)
      .def_property_readonly("bodies", &body_names)
      .def_property_readonly("pairs", &pair_names)
      .def_property_readonly("left_out", &left_out);

  py::class_<CollisionScene>(module, "CollisionScene")
      .def_readonly("names", &CollisionScene::names);

  module.def("itself", &itself, py::arg("model"));
  module.def(
      "against",
      [](const CollisionModel& model, const std::vector<Shape>& obstacles) {
        return against(model, placed_shapes(obstacles));
      },
      py::arg("model"), py::arg("obstacles"));
  module.def(
      "clear_batch",
      [](const CollisionModel& model, const std::vector<Shape>& obstacles,
         const Eigen::Ref<const Rows>& q, double margin, double self_collision_margin) {
        const Unlocked unlocked;
        return clear_batch(
            whole_arm(model, placed_shapes(obstacles), margin, self_collision_margin), q);
      },
      py::arg("model"), py::arg("obstacles"), py::arg("q").noconvert(), py::arg("margin"),
      py::arg("self_collision_margin"));
  module.def(
      "clear_edges",
      [](const CollisionModel& model, const std::vector<Shape>& obstacles,
         const Eigen::Ref<const Rows>& starts, const Eigen::Ref<const Rows>& ends, double margin,
         double self_collision_margin, int threads) {
        require(starts.cols() == model.chain.joints() && ends.cols() == starts.cols() &&
                ends.rows() == starts.rows());
        const Unlocked unlocked;
        return clear_edges(whole_arm(without_meeting_pairs(model), placed_shapes(obstacles), margin,
                                     self_collision_margin),
                           starts, ends, threads);
      },
      py::arg("model"), py::arg("obstacles"), py::arg("starts").noconvert(),
      py::arg("ends").noconvert(), py::arg("margin"), py::arg("self_collision_margin"),
      py::arg("threads"));
  module.def("nearest_bodies", &nearest, py::arg("scene"), py::arg("q").noconvert(),
             py::arg("threads"));
  module.def("check_motion", &check, py::arg("scene"), py::arg("q").noconvert(), py::arg("margin"),
             py::arg("tolerance"), py::arg("threads"));
  module.def("longest_step", &longest_step, py::arg("scene"), py::arg("q").noconvert(),
             Unlocking());
}

}  // namespace leadthrough
