#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "bind/parts.hpp"
#include "leadthrough/collision/shapes.hpp"
#include "leadthrough/path/clear_path.hpp"
#include "leadthrough/path/connect.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

// model: none without collision checks. tube: see TipPath. Returns joints, or none and the dead
// end: the last configuration, the sample, and colliding pairs of bodies with counts; then the
// closest pair if the path found is not clear between samples.
py::tuple clear_path(const Chain& chain, const CollisionModel* own_shapes,
                     const std::vector<Shape>& obstacles, const Rows3Ref& positions,
                     const Rows4Ref& orientations, const std::optional<IkAxes>& axes,
                     const RowsRef& postures, const std::optional<Eigen::VectorXd>& start,
                     double margin, double self_collision_margin, const IkTolerance& tolerance,
                     const RowsRef& tube, int max_attempts) {
  require(!start || start->size() == chain.joints());
  CollisionModel model;
  if (own_shapes != nullptr)
    model = without_meeting_pairs(*own_shapes);
  else
    model.chain = chain;
  const PlacedShapes shapes = placed_shapes(obstacles);
  path::ClearPath found = without_gil([&] {
    std::optional<JointArray> near;
    if (start) std::copy(start->data(), start->data() + start->size(), near.emplace().begin());
    return path::find_clear_path(model, shapes, {positions, orientations, axes, tube}, postures,
                                 near, {margin, self_collision_margin}, tolerance, max_attempts);
  });
  const CollisionScene scene = whole_arm(model, shapes, margin, self_collision_margin).scene;
  std::vector<std::tuple<std::string, std::string, int>> blocking;
  const auto name = [&](int shape) {
    return scene
        .names[static_cast<std::size_t>(scene.shapes[static_cast<std::size_t>(shape)].body)];
  };
  for (const auto& [pair, count] : found.dead_end.pairs)
    blocking.emplace_back(name(scene.pairs[pair].a), name(scene.pairs[pair].b), count);
  py::object touch = py::none();
  if (found.touch)
    touch = py::make_tuple(found.touch->sample, found.touch->nearest.distance,
                           scene.names[static_cast<std::size_t>(found.touch->nearest.a)],
                           scene.names[static_cast<std::size_t>(found.touch->nearest.b)]);
  py::object last = py::none();
  if (found.last)
    last = py::cast(
        Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(found.last->data(), chain.joints())));
  return py::make_tuple(std::move(found.q), std::move(last), found.dead_end.sample,
                        std::move(blocking), std::move(touch));
}

Rows connect_(const CollisionModel& model, const std::vector<Shape>& obstacles,
              const Eigen::VectorXd& start, const RowsRef& goals, const Eigen::VectorXd& lower,
              const Eigen::VectorXd& upper, double margin, double self_collision_margin,
              std::uint64_t seed, long steps) {
  const Unlocked unlocked;
  const WholeArm arm = whole_arm(without_meeting_pairs(model), placed_shapes(obstacles), margin,
                                 self_collision_margin);
  return connect(arm, start, goals, {seed, steps, lower, upper});
}

}  // namespace

void bind_path(py::module_& module) {
  module.def("clear_path", &clear_path, "chain"_a, "model"_a, "obstacles"_a, "positions"_array,
             "orientations"_array, "axes"_a, "postures"_array, "start"_a, "margin"_a,
             "self_collision_margin"_a, "tolerance"_a, "tube"_array = Rows(0, 6),
             "max_attempts"_a = path::kMaxAttempts);
  module.def("connect", &connect_, "model"_a, "obstacles"_a, "start"_a, "goals"_array, "lower"_a,
             "upper"_a, "margin"_a, "self_collision_margin"_a, "seed"_a, "steps"_a);
}

}  // namespace leadthrough
