#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <cmath>

#include "bind/parts.hpp"
#include "leadthrough/ik/arm_tasks.hpp"
#include "leadthrough/ik/differential_ik.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

MotionLimits limits_of(const Chain& chain, const VectorRef& velocity,
                       const VectorRef& acceleration) {
  require(velocity.size() == chain.joints() && acceleration.size() == chain.joints());
  return {chain.lower, chain.upper, velocity, acceleration};
}

TaskStack make_stack(const Chain& chain, const std::vector<ArmTask>& tasks,
                     const VectorRef& velocity, const VectorRef& acceleration, bool reverse,
                     double rest_damping) {
  TaskStack stack{chain, tasks, limits_of(chain, velocity, acceleration),
                  reverse ? PriorityScheme::kReverse : PriorityScheme::kForward, rest_damping};
  check_sizes(stack);
  return stack;
}

py::tuple reports(const TaskStack& stack, const StackMotion& solution) {
  const auto* first = solution.reports.data();
  const std::vector<TaskReport> tasks(first, first + stack.tasks.size());
  return py::make_tuple(
      column<double>(tasks, &TaskReport::error), column<double>(tasks, &TaskReport::residual),
      column<double>(tasks, &TaskReport::activation), column<bool>(tasks, &TaskReport::bounded));
}

template <typename Next>
auto next_of(const TaskStack& stack, const VectorRef& q, const VectorRef& qd, double dt,
             const Next& next) {
  return without_gil([&] {
    StackWorkspace workspace(stack);
    return next(stack, q, qd, dt, workspace);
  });
}

py::tuple velocity(const TaskStack& stack, const VectorRef& q, const VectorRef& qd, double dt) {
  const StackMotion solution = next_of(stack, q, qd, dt, stack_velocity);
  return py::make_tuple(solution.motion, reports(stack, solution));
}

py::tuple acceleration(const TaskStack& stack, const VectorRef& q, const VectorRef& qd, double dt) {
  const StackMotion solution = next_of(stack, q, qd, dt, stack_acceleration);
  return py::make_tuple(solution.motion, reports(stack, solution));
}

py::tuple step(const TaskStack& stack, const VectorRef& q, const VectorRef& qd, double dt) {
  const StackStep next = next_of(stack, q, qd, dt, stack_step);
  return py::make_tuple(next.q, next.qd, reports(stack, next.solution));
}

bool is_rotation(const VectorRef& orientation) {
  constexpr double kUnitTolerance = 1e-2;  // that of check.quaternions
  return orientation.size() == 4 && std::abs(orientation.norm() - 1.0) <= kUnitTolerance;
}

// A control loop's arrays come without a check of their own: what the core refuses, the Python
// layer explains. `orientation` has four numbers or none.
py::tuple differential(const DifferentialIk& solver, const VectorRef& q, const VectorRef& qd,
                       const VectorRef& position, const VectorRef& orientation,
                       const VectorRef& twist) {
  require(position.size() == 3 && twist.size() == 6 &&
          (orientation.size() == 0 || is_rotation(orientation)));
  const DifferentialStep next = without_gil([&] {
    IkTarget target{position, std::nullopt};
    if (orientation.size() == 4) target.rotation = so3::to_matrix(orientation.normalized());
    return differential_step(solver, target, twist, q, qd);
  });
  return py::make_tuple(next.q, next.qd, next.position_error, next.orientation_error);
}

// A task of a frame that its goal's members describe.
template <typename Goal, typename... Values>
void def_task(py::module_& module, const char* name,
              const std::pair<const char*, Values Goal::*>&... fields) {
  module.def(
      name,
      [make = maker(fields.second...)](const Frame& frame, const Values&... values, double gain,
                                       double damping_ratio) {
        return ArmTask{make(values...), frame, gain, damping_ratio};
      },
      "frame"_a, py::arg(fields.first)..., "gain"_a, "damping_ratio"_a);
}

void bind_tasks(py::module_& module) {
  using Vector3 = Eigen::Vector3d;
  py::class_<Frame>(module, "Frame")
      .def(py::init([](const Chain& chain, const Vector3& offset) {
             Frame frame = tip_frame(chain);
             frame.T_joint_frame.position += frame.T_joint_frame.rotation * offset;
             return frame;
           }),
           "chain"_a, "offset"_a);
  py::class_<ArmTask>(module, "ArmTask");
  module.def(
      "pose_task",
      [](const Frame& frame, const Vector3& position, const Eigen::Vector4d& orientation,
         const Vector6& twist, double gain, double damping_ratio) {
        return ArmTask{PoseGoal{position, so3::to_matrix(orientation), twist}, frame, gain,
                       damping_ratio};
      },
      "frame"_a, "position"_a, "orientation"_a, "twist"_a, "gain"_a, "damping_ratio"_a);
  def_task(module, "position_task", std::pair("position", &PositionGoal::position),
           std::pair("velocity", &PositionGoal::velocity));
  def_task(module, "direction_task", std::pair("axis", &DirectionGoal::axis),
           std::pair("direction", &DirectionGoal::direction));
  def_task(module, "cone_task", std::pair("axis", &ConeGoal::axis),
           std::pair("direction", &ConeGoal::direction), std::pair("cosine", &ConeGoal::cosine),
           std::pair("margin", &ConeGoal::margin));
  def_task(module, "plane_task", std::pair("direction", &PlaneGoal::direction),
           std::pair("height", &PlaneGoal::height));
  def_task(module, "clearance_task", std::pair("shape", &ClearanceGoal::shape),
           std::pair("distance", &ClearanceGoal::distance),
           std::pair("margin", &ClearanceGoal::margin));
  module.def(
      "posture_task",
      [](const VectorRef& q, const VectorRef& velocity_, double gain, double damping_ratio) {
        require(q.size() <= kMaxJoints && velocity_.size() <= kMaxJoints);
        return ArmTask{PostureGoal{q, velocity_}, {}, gain, damping_ratio};
      },
      "q"_array, "velocity"_array, "gain"_a, "damping_ratio"_a);
  module.def(
      "joint_limit_task",
      [](double margin, double gain, double damping_ratio) {
        return ArmTask{JointLimitGoal{margin}, {}, gain, damping_ratio};
      },
      "margin"_a, "gain"_a, "damping_ratio"_a);
}

}  // namespace

void bind_priority(py::module_& module) {
  bind_tasks(module);
  py::class_<TaskStack>(module, "TaskStack")
      .def(py::init(&make_stack), "chain"_a, "tasks"_a, "velocity"_array, "acceleration"_array,
           "reverse"_a, "rest_damping"_a)
      .def("velocity", &velocity, "q"_array, "qd"_array, "dt"_a)
      .def("acceleration", &acceleration, "q"_array, "qd"_array, "dt"_a)
      .def("step", &step, "q"_array, "qd"_array, "dt"_a);

  py::class_<DifferentialIk>(module, "DifferentialIk")
      .def(py::init([](const Chain& chain, const VectorRef& velocity_,
                       const VectorRef& acceleration_, const VectorRef& posture, double dt,
                       double gain, double posture_gain) {
             require(posture.size() == chain.joints());
             DifferentialIk solver{chain,   limits_of(chain, velocity_, acceleration_),
                                   posture, dt,
                                   gain,    posture_gain};
             check_sizes(solver);
             return solver;
           }),
           "chain"_a, "velocity"_array, "acceleration"_array, "posture"_array, "dt"_a, "gain"_a,
           "posture_gain"_a)
      .def("step", &differential, "q"_array, "qd"_array, "position"_array, "orientation"_array,
           "twist"_array);

  module.def(
      "resolve_stack",
      [](const std::vector<Rows>& jacobians, const std::vector<Eigen::VectorXd>& wanted,
         const VectorRef& lower, const VectorRef& upper, bool reverse) {
        const Eigen::Index n = lower.size();
        require(upper.size() == n && n <= kMaxJoints && wanted.size() == jacobians.size() &&
                jacobians.size() <= static_cast<std::size_t>(kMaxTasks));
        std::vector<Level> levels(jacobians.size());
        for (std::size_t i = 0; i < levels.size(); ++i) {
          require(jacobians[i].cols() == n && jacobians[i].rows() <= kMaxJoints &&
                  jacobians[i].rows() == wanted[i].size());
          levels[i].jacobian = jacobians[i];
          levels[i].wanted = wanted[i];
        }
        const Unlocked unlocked;
        const auto scheme = reverse ? PriorityScheme::kReverse : PriorityScheme::kForward;
        return Eigen::VectorXd(resolve(levels, {lower, upper}, scheme));
      },
      "jacobians"_a, "wanted"_a, "lower"_array, "upper"_array, "reverse"_a);
}

}  // namespace leadthrough
