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

using Vector = Eigen::Ref<const Eigen::VectorXd>;

MotionLimits limits_of(const Chain& chain, const Vector& velocity, const Vector& acceleration) {
  require(velocity.size() == chain.joints() && acceleration.size() == chain.joints());
  return {chain.lower, chain.upper, velocity, acceleration};
}

TaskStack make_stack(const Chain& chain, const std::vector<ArmTask>& tasks, const Vector& velocity,
                     const Vector& acceleration, bool reverse, double rest_damping) {
  TaskStack stack{chain, tasks, limits_of(chain, velocity, acceleration),
                  reverse ? PriorityScheme::kReverse : PriorityScheme::kForward, rest_damping};
  check_sizes(stack);
  return stack;
}

py::tuple reports(const TaskStack& stack, const StackMotion& solution) {
  const auto count = static_cast<Eigen::Index>(stack.tasks.size());
  Eigen::VectorXd error(count), residual(count), activation(count);
  Eigen::Matrix<bool, Eigen::Dynamic, 1> bounded(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const TaskReport& report = solution.reports[static_cast<std::size_t>(i)];
    error[i] = report.error;
    residual[i] = report.residual;
    activation[i] = report.activation;
    bounded[i] = report.bounded;
  }
  return py::make_tuple(std::move(error), std::move(residual), std::move(activation),
                        std::move(bounded));
}

py::tuple velocity(const TaskStack& stack, const Vector& q, const Vector& qd, double dt) {
  StackMotion solution;
  {
    const Unlocked unlocked;
    StackWorkspace workspace(stack);
    solution = stack_velocity(stack, q, qd, dt, workspace);
  }
  return py::make_tuple(solution.motion, reports(stack, solution));
}

py::tuple acceleration(const TaskStack& stack, const Vector& q, const Vector& qd, double dt) {
  StackMotion solution;
  {
    const Unlocked unlocked;
    StackWorkspace workspace(stack);
    solution = stack_acceleration(stack, q, qd, dt, workspace);
  }
  return py::make_tuple(solution.motion, reports(stack, solution));
}

py::tuple step(const TaskStack& stack, const Vector& q, const Vector& qd, double dt) {
  StackStep next;
  {
    const Unlocked unlocked;
    StackWorkspace workspace(stack);
    next = stack_step(stack, q, qd, dt, workspace);
  }
  return py::make_tuple(next.q, next.qd, reports(stack, next.solution));
}

bool is_rotation(const Vector& orientation) {
  constexpr double kUnitTolerance = 1e-2;  // that of check.quaternions
  return orientation.size() == 4 && std::abs(orientation.norm() - 1.0) <= kUnitTolerance;
}

// A control loop's arrays come without a check of their own: what the core refuses, the Python
// layer explains. `orientation` has four numbers or none.
py::tuple differential(const DifferentialIk& solver, const Vector& q, const Vector& qd,
                       const Vector& position, const Vector& orientation, const Vector& twist) {
  require(position.size() == 3 && twist.size() == 6 &&
          (orientation.size() == 0 || is_rotation(orientation)));
  DifferentialStep next;
  {
    const Unlocked unlocked;
    IkTarget target{position, std::nullopt};
    if (orientation.size() == 4) target.rotation = so3::to_matrix(orientation.normalized());
    next = differential_step(solver, target, twist, q, qd);
  }
  return py::make_tuple(next.q, next.qd, next.position_error, next.orientation_error);
}

void bind_tasks(py::module_& module) {
  using Vector3 = Eigen::Vector3d;
  py::class_<Frame>(module, "Frame")
      .def(py::init([](const Chain& chain, const Vector3& offset) {
             Frame frame = tip_frame(chain);
             frame.T_joint_frame.position += frame.T_joint_frame.rotation * offset;
             return frame;
           }),
           py::arg("chain"), py::arg("offset"));
  py::class_<ArmTask>(module, "ArmTask");
  module.def(
      "pose_task",
      [](const Frame& frame, const Vector3& position, const Eigen::Vector4d& orientation,
         const Vector6& twist, double gain, double damping_ratio) {
        return ArmTask{PoseGoal{position, so3::to_matrix(orientation), twist}, frame, gain,
                       damping_ratio};
      },
      py::arg("frame"), py::arg("position"), py::arg("orientation"), py::arg("twist"),
      py::arg("gain"), py::arg("damping_ratio"));
  module.def(
      "position_task",
      [](const Frame& frame, const Vector3& position, const Vector3& velocity_, double gain,
         double damping_ratio) {
        return ArmTask{PositionGoal{position, velocity_}, frame, gain, damping_ratio};
      },
      py::arg("frame"), py::arg("position"), py::arg("velocity"), py::arg("gain"),
      py::arg("damping_ratio"));
  module.def(
      "direction_task",
      [](const Frame& frame, const Vector3& axis, const Vector3& direction, double gain,
         double damping_ratio) {
        return ArmTask{DirectionGoal{axis, direction}, frame, gain, damping_ratio};
      },
      py::arg("frame"), py::arg("axis"), py::arg("direction"), py::arg("gain"),
      py::arg("damping_ratio"));
  module.def(
      "cone_task",
      [](const Frame& frame, const Vector3& axis, const Vector3& direction, double cosine,
         double margin, double gain, double damping_ratio) {
        return ArmTask{ConeGoal{axis, direction, cosine, margin}, frame, gain, damping_ratio};
      },
      py::arg("frame"), py::arg("axis"), py::arg("direction"), py::arg("cosine"), py::arg("margin"),
      py::arg("gain"), py::arg("damping_ratio"));
  module.def(
      "posture_task",
      [](const Vector& q, const Vector& velocity_, double gain, double damping_ratio) {
        require(q.size() <= kMaxJoints && velocity_.size() <= kMaxJoints);
        return ArmTask{PostureGoal{q, velocity_}, {}, gain, damping_ratio};
      },
      py::arg("q").noconvert(), py::arg("velocity").noconvert(), py::arg("gain"),
      py::arg("damping_ratio"));
  module.def(
      "joint_limit_task",
      [](double margin, double gain, double damping_ratio) {
        return ArmTask{JointLimitGoal{margin}, {}, gain, damping_ratio};
      },
      py::arg("margin"), py::arg("gain"), py::arg("damping_ratio"));
  module.def(
      "plane_task",
      [](const Frame& frame, const Vector3& direction, double height, double gain,
         double damping_ratio) {
        return ArmTask{PlaneGoal{direction, height}, frame, gain, damping_ratio};
      },
      py::arg("frame"), py::arg("direction"), py::arg("height"), py::arg("gain"),
      py::arg("damping_ratio"));
  module.def(
      "clearance_task",
      [](const Frame& frame, const Shape& shape, double distance, double margin, double gain,
         double damping_ratio) {
        return ArmTask{ClearanceGoal{shape, distance, margin}, frame, gain, damping_ratio};
      },
      py::arg("frame"), py::arg("shape"), py::arg("distance"), py::arg("margin"), py::arg("gain"),
      py::arg("damping_ratio"));
}

}  // namespace

void bind_priority(py::module_& module) {
  bind_tasks(module);
  py::class_<TaskStack>(module, "TaskStack")
      .def(py::init(&make_stack), py::arg("chain"), py::arg("tasks"),
           py::arg("velocity").noconvert(), py::arg("acceleration").noconvert(), py::arg("reverse"),
           py::arg("rest_damping"))
      .def("velocity", &velocity, py::arg("q").noconvert(), py::arg("qd").noconvert(),
           py::arg("dt"))
      .def("acceleration", &acceleration, py::arg("q").noconvert(), py::arg("qd").noconvert(),
           py::arg("dt"))
      .def("step", &step, py::arg("q").noconvert(), py::arg("qd").noconvert(), py::arg("dt"));

  py::class_<DifferentialIk>(module, "DifferentialIk")
      .def(py::init([](const Chain& chain, const Vector& velocity_, const Vector& acceleration_,
                       const Vector& posture, double dt, double gain, double posture_gain) {
             require(posture.size() == chain.joints());
             DifferentialIk solver{chain,   limits_of(chain, velocity_, acceleration_),
                                   posture, dt,
                                   gain,    posture_gain};
             check_sizes(solver);
             return solver;
           }),
           py::arg("chain"), py::arg("velocity").noconvert(), py::arg("acceleration").noconvert(),
           py::arg("posture").noconvert(), py::arg("dt"), py::arg("gain"), py::arg("posture_gain"))
      .def("step", &differential, py::arg("q").noconvert(), py::arg("qd").noconvert(),
           py::arg("position").noconvert(), py::arg("orientation").noconvert(),
           py::arg("twist").noconvert());

  module.def(
      "resolve_stack",
      [](const std::vector<Rows>& jacobians, const std::vector<Eigen::VectorXd>& wanted,
         const Vector& lower, const Vector& upper, bool reverse) {
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
      py::arg("jacobians"), py::arg("wanted"), py::arg("lower").noconvert(),
      py::arg("upper").noconvert(), py::arg("reverse"));
}

}  // namespace leadthrough
