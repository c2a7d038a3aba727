#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>

#include "bind/parts.hpp"
#include "leadthrough/ik/closed_form.hpp"
#include "leadthrough/ik/solve.hpp"
#include "leadthrough/ik/yang.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

IkTarget to_target(const Eigen::Ref<const Eigen::Vector3d>& position,
                   const Eigen::Ref<const Eigen::VectorXd>& orientation) {
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

struct IkColumns {
  Rows q;
  Eigen::VectorXi status;
  Eigen::VectorXd position_errors, orientation_errors;
  Eigen::VectorXi iterations;
  Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> limiting;
};

IkColumns columns(const std::vector<IkResult>& results, int joints) {
  const auto count = static_cast<Eigen::Index>(results.size());
  IkColumns table{Rows(count, joints),    Eigen::VectorXi(count), Eigen::VectorXd(count),
                  Eigen::VectorXd(count), Eigen::VectorXi(count), {}};
  table.limiting.resize(count, joints);
  for (Eigen::Index i = 0; i < count; ++i) {
    const IkResult& result = results[static_cast<std::size_t>(i)];
    table.q.row(i) = result.q;
    table.status[i] = static_cast<int>(result.status);
    table.position_errors[i] = result.position_error;
    table.orientation_errors[i] = result.orientation_error;
    table.iterations[i] = result.iterations;
    std::copy(result.limiting.begin(), result.limiting.begin() + joints,
              table.limiting.row(i).data());
  }
  return table;
}

template <typename Solve>
py::tuple solve_columns(int joints, const Solve& solve) {
  IkColumns table = without_gil([&] { return columns(solve(), joints); });
  return py::make_tuple(std::move(table.q), std::move(table.status),
                        std::move(table.position_errors), std::move(table.orientation_errors),
                        std::move(table.iterations), std::move(table.limiting));
}

// `orientation` has four numbers or none.
py::tuple solve_one(const Chain& chain, const Eigen::Ref<const Eigen::Vector3d>& position,
                    const Eigen::Ref<const Eigen::VectorXd>& orientation,
                    const Eigen::Ref<const Eigen::VectorXd>& q0, const IkOptions& options,
                    const ClosedForm* form) {
  require(orientations_fit(4, orientation.size()));
  require_form(chain, form);
  IkResult result = without_gil(
      [&] { return solve_ik(chain, to_target(position, orientation), q0, options, 0, form); });
  return to_tuple(result);
}

py::tuple solve_batch(const Chain& chain, const Eigen::Ref<const Rows3>& positions,
                      const Eigen::Ref<const Rows4>& orientations,
                      const Eigen::Ref<const Rows>& starts, const IkOptions& options, int threads,
                      const ClosedForm* form) {
  require_form(chain, form);
  return solve_columns(chain.joints(), [&] {
    return solve_ik_batch(chain, positions, orientations, starts, options, threads, form);
  });
}

// Rows, errors in position and orientation, iterations, status of none, whether these are all, and
// the resolution of a sweep.
py::tuple solve_all(const Chain& chain, const Eigen::Ref<const Eigen::Vector3d>& position,
                    const Eigen::Ref<const Eigen::VectorXd>& orientation,
                    const Eigen::Ref<const Eigen::VectorXd>& q0, const IkOptions& options,
                    int count, double separation, const ClosedForm* form) {
  require(orientations_fit(4, orientation.size()));
  require_form(chain, form);
  IkSolutions solutions = without_gil([&] {
    return solve_ik_all(chain, to_target(position, orientation), q0, options, count, separation,
                        form);
  });
  const auto rows = static_cast<py::ssize_t>(solutions.found.size());
  // Filled in place: to hand over Eigen's memory takes longer.
  py::array_t<double> q({rows, static_cast<py::ssize_t>(chain.joints())});
  py::array_t<double> position_errors(rows), orientation_errors(rows);
  py::array_t<int> iterations(rows);
  for (py::ssize_t i = 0; i < rows; ++i) {
    const IkResult& each = solutions.found[static_cast<std::size_t>(i)];
    std::copy(each.q.begin(), each.q.end(), q.mutable_data(i));
    position_errors.mutable_at(i) = each.position_error;
    orientation_errors.mutable_at(i) = each.orientation_error;
    iterations.mutable_at(i) = each.iterations;
  }
  return py::make_tuple(std::move(q), std::move(position_errors), std::move(orientation_errors),
                        std::move(iterations), static_cast<int>(solutions.status),
                        solutions.complete, solutions.resolution);
}

py::tuple solve_plainly(const Chain& chain, const Eigen::Ref<const Rows3>& positions,
                        const Eigen::Ref<const Rows4>& orientations,
                        const Eigen::Ref<const Rows>& starts, const IkTolerance& tolerance,
                        int max_iterations, const YangOptions& options, int threads) {
  return solve_columns(chain.joints(), [&] {
    return solve_yang_batch(chain, positions, orientations, starts, tolerance, max_iterations,
                            options, threads);
  });
}

py::tuple step_along(const Chain& chain, const Eigen::Ref<const Rows3>& positions,
                     const Eigen::Ref<const Rows4>& orientations,
                     const Eigen::Ref<const Eigen::VectorXd>& start,
                     const Eigen::Ref<const Eigen::VectorXd>& steps, const YangOptions& options) {
  YangPath path =
      without_gil([&] { return yang_path(chain, positions, orientations, start, steps, options); });
  return py::make_tuple(std::move(path.q), std::move(path.condition), std::move(path.damping),
                        std::move(path.position_errors), std::move(path.orientation_errors));
}

}  // namespace

void bind_ik(py::module_& module) {
  py::class_<IkTolerance>(module, "IkTolerance")
      .def(py::init([](double position, double orientation) {
             return IkTolerance{position, orientation};
           }),
           py::arg("position"), py::arg("orientation"));

  py::class_<IkAxes>(module, "IkAxes")
      .def(py::init([](const std::array<bool, 6>& free, const Vector6& tolerance,
                       const Vector6& weight) { return IkAxes{free, tolerance, weight}; }),
           py::arg("free"), py::arg("tolerance"), py::arg("weight"));

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
           py::arg("tolerance"), py::arg("axes"), py::arg("mode"), py::arg("reference"),
           py::arg("nullspace_gain"), py::arg("posture"), py::arg("max_iterations"),
           py::arg("max_restarts"), py::arg("max_cpu_seconds"), py::arg("seed"));

  py::class_<YangOptions>(module, "YangOptions")
      .def(py::init([](double damping, double alpha, double condition_threshold,
                       double nullspace_gain, double rotation_weight) {
             return YangOptions{damping, alpha, condition_threshold, nullspace_gain,
                                rotation_weight};
           }),
           py::arg("damping"), py::arg("alpha"), py::arg("condition_threshold"),
           py::arg("nullspace_gain"), py::arg("rotation_weight"));

  py::class_<ClosedForm>(module, "ClosedForm")
      .def_readonly("deviation", &ClosedForm::deviation)
      .def_property_readonly("joints", [](const ClosedForm& form) { return form.joints(); });
  module.def("recognize", &recognize, py::arg("chain"));

  module.def("solve_ik", &solve_one, py::arg("chain"), py::arg("position").noconvert(),
             py::arg("orientation").noconvert(), py::arg("q0").noconvert(), py::arg("options"),
             py::arg("form"));
  module.def("solve_ik_batch", &solve_batch, py::arg("chain"), py::arg("positions").noconvert(),
             py::arg("orientations").noconvert(), py::arg("starts").noconvert(), py::arg("options"),
             py::arg("threads"), py::arg("form"));
  module.def("solve_ik_all", &solve_all, py::arg("chain"), py::arg("position").noconvert(),
             py::arg("orientation").noconvert(), py::arg("q0").noconvert(), py::arg("options"),
             py::arg("count"), py::arg("separation"), py::arg("form"));
  module.def("solve_yang", &solve_plainly, py::arg("chain"), py::arg("positions").noconvert(),
             py::arg("orientations").noconvert(), py::arg("starts").noconvert(),
             py::arg("tolerance"), py::arg("max_iterations"), py::arg("options"),
             py::arg("threads"));
  module.def("yang_path", &step_along, py::arg("chain"), py::arg("positions").noconvert(),
             py::arg("orientations").noconvert(), py::arg("start").noconvert(),
             py::arg("steps").noconvert(), py::arg("options"));
}

}  // namespace leadthrough
