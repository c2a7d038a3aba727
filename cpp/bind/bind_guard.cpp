#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <optional>
#include <tuple>
#include <utility>

#include "bind/parts.hpp"
#include "leadthrough/collision/shapes.hpp"
#include "leadthrough/guard/brake.hpp"
#include "leadthrough/guard/bridge.hpp"
#include "leadthrough/guard/contact.hpp"
#include "leadthrough/guard/pace.hpp"
#include "leadthrough/guard/path_curve.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using Eigen::Index;
using guard::GuardedScene;
using guard::StepLimits;

StepLimits make_limits(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                       const Eigen::VectorXd& velocity, const Eigen::VectorXd& acceleration,
                       const Eigen::VectorXd& jerk, double period) {
  StepLimits limits{lower, upper, velocity, acceleration, jerk, period};
  guard::check_limits(limits);
  return limits;
}

// order, sample, joint, ratio; for order 0 the position.
std::optional<std::tuple<int, Index, Index, double>> first_excess(const StepLimits& limits,
                                                                  const RowsRef& start,
                                                                  const RowsRef& samples) {
  const Unlocked unlocked;
  const auto found = guard::first_excess(limits, start, samples);
  if (!found) return std::nullopt;
  return std::make_tuple(found->order, found->sample, found->joint, found->ratio);
}

template <typename Find>
auto bridge(const Find& find) {
  return [find](const StepLimits& limits, const RowsRef& start, const RowsRef& target,
                Index most_steps) -> std::optional<std::pair<Rows, Index>> {
    const Unlocked unlocked;
    auto found = find(limits, start, target, most_steps);
    if (!found) return std::nullopt;
    return std::make_pair(std::move(found->samples), found->skipped);
  };
}

using PacedRows = std::optional<std::pair<Rows, Eigen::VectorXd>>;

PacedRows pair_of(std::optional<guard::Paced> paced) {
  if (!paced) return std::nullopt;
  return std::make_pair(std::move(paced->samples), std::move(paced->places));
}

PacedRows slowed(const StepLimits& limits, const RowsRef& path, Index most_samples) {
  const Unlocked unlocked;
  return pair_of(guard::slowed(limits, path, most_samples));
}

PacedRows stopped(const StepLimits& limits, const RowsRef& start, const RowsRef& path) {
  const Unlocked unlocked;
  return pair_of(guard::stopped(limits, start, path));
}

PacedRows eased(const StepLimits& limits, const RowsRef& start, const RowsRef& path, double rate) {
  const Unlocked unlocked;
  return pair_of(guard::eased(limits, start, path, rate));
}

// Along states, or positions alone: sample and the two bodies by name, or empty names where the
// work ended.
std::optional<std::tuple<double, std::string, std::string>> first_contact(
    const GuardedScene& guarded, const Eigen::VectorXd& start, const RowsRef& samples, double age,
    long most_work) {
  const CollisionScene& scene = guarded.arm.scene;
  const Index joints = scene.chain.joints();
  require(start.size() == joints || start.size() == 3 * joints);
  require(samples.cols() == joints || samples.cols() == 3 * joints);
  const Unlocked unlocked;
  const auto found =
      guard::first_contact(guarded, start.head(joints), samples.leftCols(joints), age, most_work);
  if (!found) return std::nullopt;
  if (found->a < 0) return std::make_tuple(found->sample, std::string(), std::string());
  return std::make_tuple(found->sample, scene.names[static_cast<std::size_t>(found->a)],
                         scene.names[static_cast<std::size_t>(found->b)]);
}

}  // namespace

void bind_guard(py::module_& module) {
  py::class_<StepLimits>(module, "StepLimits")
      .def(py::init(&make_limits), "lower"_a, "upper"_a, "velocity"_a, "acceleration"_a, "jerk"_a,
           "period"_a);
  module.def("first_excess", &first_excess, "limits"_a, "start"_array, "samples"_array);
  module.def("with_rates", &guard::with_rates, "times"_a, "positions"_array, "start"_array,
             "period"_a, Unlocking());
  module.def("brake", &guard::brake, "limits"_a, "start"_array, Unlocking());
  module.def("bridge_to_start", bridge(&guard::bridge_to_start), "limits"_a, "start"_array,
             "target"_array, "most_steps"_a);
  module.def("bridge_on_time", bridge(&guard::bridge_on_time), "limits"_a, "start"_array,
             "target"_array, "most_steps"_a);
  module.def("joined", &guard::joined, "limits"_a, "start"_array, "target"_array, "jerk"_a, "use"_a,
             Unlocking());
  module.def("slowed", &slowed, "limits"_a, "path"_array, "most_samples"_a);
  module.def("stopped", &stopped, "limits"_a, "start"_array, "path"_array);
  module.def("eased", &eased, "limits"_a, "start"_array, "path"_array, "rate"_a);

  py::class_<GuardedScene>(module, "GuardedScene")
      .def(py::init([](const CollisionModel& model, const std::vector<Shape>& obstacles,
                       const std::vector<double>& growth, double margin,
                       double self_collision_margin) {
             return guard::guarded_scene(model, placed_shapes(obstacles), growth, margin,
                                         self_collision_margin);
           }),
           "model"_a, "obstacles"_a, "growth"_a, "margin"_a, "self_collision_margin"_a);
  module.def("first_contact", &first_contact, "scene"_a, "start"_a, "samples"_array, "age"_a,
             "most_work"_a = guard::kAllWork);
}

}  // namespace leadthrough
