#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>

#include "bind/parts.hpp"
#include "leadthrough/ik/closed_form.hpp"
#include "leadthrough/ik/solve.hpp"
#include "leadthrough/ik/tracking.hpp"
#include "leadthrough/ik/yang.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using Vector3Ref = Eigen::Ref<const Eigen::Vector3d>;

IkTarget to_target(const Vector3Ref& position, const VectorRef& orientation) {
  IkTarget target{position, std::nullopt};
  if (orientation.size() == 4) target.rotation = so3::to_matrix(orientation);
  return target;
}

void require_form(const Chain& chain, const ClosedForm* form) {
  require(!form || form->joints() == chain.joints());
}

std::optional<JointVector> to_joints(const std::optional<Eigen::VectorXd>& q) {
  require(!q || q->size() <= kMaxJoints);
  return q ? std::optional<JointVector>(*q) : std::nullopt;
}

// One bit a joint.
unsigned to_bits(const std::array<bool, kMaxJoints>& limiting) {
  unsigned bits = 0;
  for (std::size_t i = 0; i < limiting.size(); ++i) bits |= unsigned{limiting[i]} << i;
  return bits;
}

py::tuple to_tuple(const IkResult& result) {
  return py::make_tuple(result.q, static_cast<int>(result.status), result.position_error,
                        result.orientation_error, result.iterations, to_bits(result.limiting));
}

py::array_t<double> joint_rows(const std::vector<IkResult>& results, int joints) {
  py::array_t<double> rows({static_cast<py::ssize_t>(results.size()), py::ssize_t{joints}});
  double* row = rows.mutable_data();
  for (const IkResult& each : results) row = std::copy(each.q.begin(), each.q.end(), row);
  return rows;
}

template <typename Solve>
py::tuple solve_columns(int joints, const Solve& solve) {
  const std::vector<IkResult> results = without_gil(solve);
  py::array_t<bool> limiting({static_cast<py::ssize_t>(results.size()), py::ssize_t{joints}});
  bool* row = limiting.mutable_data();
  for (const IkResult& each : results) row = std::copy_n(each.limiting.begin(), joints, row);
  return py::make_tuple(joint_rows(results, joints), column<int>(results, &IkResult::status),
                        column<double>(results, &IkResult::position_error),
                        column<double>(results, &IkResult::orientation_error),
                        column<int>(results, &IkResult::iterations), std::move(limiting));
}

// `orientation` has four numbers or none.
py::tuple solve_one(const Chain& chain, const Vector3Ref& position, const VectorRef& orientation,
                    const VectorRef& q0, const IkOptions& options, const ClosedForm* form) {
  require(orientations_fit(4, orientation.size()));
  require_form(chain, form);
  return to_tuple(without_gil(
      [&] { return solve_ik(chain, to_target(position, orientation), q0, options, 0, form); }));
}

py::tuple solve_batch(const Chain& chain, const Rows3Ref& positions, const Rows4Ref& orientations,
                      const RowsRef& starts, const IkOptions& options, int threads,
                      const ClosedForm* form, bool own_restarts) {
  require_form(chain, form);
  const Restarts restarts = own_restarts ? Restarts::kEachItsOwn : Restarts::kAlike;
  return solve_columns(chain.joints(), [&] {
    return solve_ik_batch(chain, positions, orientations, starts, options, threads, form, restarts);
  });
}

// Rows, errors in position and orientation, iterations, status of none, whether these are all, and
// the resolution of a sweep.
py::tuple solve_all(const Chain& chain, const Vector3Ref& position, const VectorRef& orientation,
                    const VectorRef& q0, const IkOptions& options, int count, double separation,
                    const ClosedForm* form) {
  require(orientations_fit(4, orientation.size()));
  require_form(chain, form);
  const IkSolutions solutions = without_gil([&] {
    return solve_ik_all(chain, to_target(position, orientation), q0, options, count, separation,
                        form);
  });
  return py::make_tuple(joint_rows(solutions.found, chain.joints()),
                        column<double>(solutions.found, &IkResult::position_error),
                        column<double>(solutions.found, &IkResult::orientation_error),
                        column<int>(solutions.found, &IkResult::iterations),
                        static_cast<int>(solutions.status), solutions.complete,
                        solutions.resolution);
}

py::tuple solve_plainly(const Chain& chain, const Rows3Ref& positions, const Rows4Ref& orientations,
                        const RowsRef& starts, const IkTolerance& tolerance, int max_iterations,
                        const YangOptions& options, int threads) {
  return solve_columns(chain.joints(), [&] {
    return solve_yang_batch(chain, positions, orientations, starts, tolerance, max_iterations,
                            options, threads);
  });
}

py::tuple step_along(const Chain& chain, const Rows3Ref& positions, const Rows4Ref& orientations,
                     const VectorRef& start, const VectorRef& steps, const YangOptions& options) {
  YangPath path =
      without_gil([&] { return yang_path(chain, positions, orientations, start, steps, options); });
  return py::make_tuple(std::move(path.q), std::move(path.condition), std::move(path.damping),
                        std::move(path.position_errors), std::move(path.orientation_errors));
}

py::tuple to_tuple(Track&& path) {
  return py::make_tuple(std::move(path.q), std::move(path.position_errors),
                        std::move(path.orientation_errors));
}

py::tuple track_path(const Chain& chain, const Rows3Ref& positions, const Rows4Ref& orientations,
                     const VectorRef& start, const RowsRef& postures, const VectorRef& shares,
                     const TrackOptions& options) {
  return to_tuple(without_gil(
      [&] { return track(chain, positions, orientations, start, {postures, shares}, options); }));
}

py::tuple pursue_path(const Chain& chain, const VectorRef& times, const Rows3Ref& positions,
                      const Rows4Ref& orientations, const VectorRef& start, const RowsRef& postures,
                      const VectorRef& shares, const PursuitOptions& options) {
  return to_tuple(without_gil([&] {
    return pursue(chain, {times, positions, orientations}, start, {postures, shares}, options);
  }));
}

}  // namespace

void bind_ik(py::module_& module) {
  bind_record<IkTolerance>(module, "IkTolerance", std::pair("position", &IkTolerance::position),
                           std::pair("orientation", &IkTolerance::orientation));
  bind_record<IkAxes>(module, "IkAxes", std::pair("free", &IkAxes::free),
                      std::pair("tolerance", &IkAxes::tolerance),
                      std::pair("weight", &IkAxes::weight));

  py::enum_<IkMode>(module, "IkMode")
      .value("FASTEST", IkMode::kFastest)
      .value("CLOSEST", IkMode::kClosest);

  py::class_<IkOptions>(module, "IkOptions")
      .def(py::init([](const IkTolerance& tolerance, const std::optional<IkAxes>& axes, IkMode mode,
                       const std::optional<Eigen::VectorXd>& reference, double nullspace_gain,
                       const std::optional<Eigen::VectorXd>& posture, int max_iterations,
                       int max_restarts, double max_cpu_seconds, std::uint64_t seed) {
             return IkOptions{tolerance,
                              axes,
                              mode,
                              to_joints(reference),
                              nullspace_gain,
                              to_joints(posture),
                              max_iterations,
                              max_restarts,
                              max_cpu_seconds,
                              seed};
           }),
           "tolerance"_a, "axes"_a, "mode"_a, "reference"_a, "nullspace_gain"_a, "posture"_a,
           "max_iterations"_a, "max_restarts"_a, "max_cpu_seconds"_a, "seed"_a);

  bind_record<YangOptions>(module, "YangOptions", std::pair("damping", &YangOptions::damping),
                           std::pair("alpha", &YangOptions::alpha),
                           std::pair("condition_threshold", &YangOptions::condition_threshold),
                           std::pair("nullspace_gain", &YangOptions::nullspace_gain),
                           std::pair("rotation_weight", &YangOptions::rotation_weight));

  py::class_<ClosedForm>(module, "ClosedForm")
      .def_readonly("deviation", &ClosedForm::deviation)
      .def_property_readonly("joints", [](const ClosedForm& form) { return form.joints(); });
  module.def("recognize", &recognize, "chain"_a);

  module.def("solve_ik", &solve_one, "chain"_a, "position"_array, "orientation"_array, "q0"_array,
             "options"_a, "form"_a);
  module.def("solve_ik_batch", &solve_batch, "chain"_a, "positions"_array, "orientations"_array,
             "starts"_array, "options"_a, "threads"_a, "form"_a, "own_restarts"_a);
  module.def("solve_ik_all", &solve_all, "chain"_a, "position"_array, "orientation"_array,
             "q0"_array, "options"_a, "count"_a, "separation"_a, "form"_a);
  module.def("solve_yang", &solve_plainly, "chain"_a, "positions"_array, "orientations"_array,
             "starts"_array, "tolerance"_a, "max_iterations"_a, "options"_a, "threads"_a);
  module.def("yang_path", &step_along, "chain"_a, "positions"_array, "orientations"_array,
             "start"_array, "steps"_array, "options"_a);

  bind_record<TrackOptions>(
      module, "TrackOptions", std::pair("tolerance", &TrackOptions::tolerance),
      std::pair("max_iterations", &TrackOptions::max_iterations),
      std::pair("max_step", &TrackOptions::max_step), std::pair("axes", &TrackOptions::axes));
  bind_record<PursuitOptions>(module, "PursuitOptions",
                              std::pair("velocity", &PursuitOptions::velocity),
                              std::pair("acceleration", &PursuitOptions::acceleration),
                              std::pair("damping", &PursuitOptions::damping),
                              std::pair("deviation", &PursuitOptions::deviation));
  module.def("track", &track_path, "chain"_a, "positions"_array, "orientations"_array,
             "start"_array, "postures"_array, "shares"_array, "options"_a);
  module.def("pursue", &pursue_path, "chain"_a, "times"_array, "positions"_array,
             "orientations"_array, "start"_array, "postures"_array, "shares"_array, "options"_a);
}

}  // namespace leadthrough
