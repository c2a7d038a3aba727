#pragma once

// The tasks of a stack, and their demands on an arm at a configuration.

#include <array>
#include <variant>
#include <vector>

#include "leadthrough/arm/frame_kinematics.hpp"
#include "leadthrough/collision/shapes.hpp"
#include "leadthrough/ik/task_priority.hpp"

namespace leadthrough {

struct PoseGoal {
  Eigen::Vector3d position;
  Eigen::Matrix3d rotation;
  Vector6 twist;  // of the goal itself, linear first, base frame
};
struct PositionGoal {
  Eigen::Vector3d position, velocity;
};
// `axis` of the frame is to point in `direction` of the base; both unit.
struct DirectionGoal {
  Eigen::Vector3d axis, direction;
};
// The same up to an angle; active within `margin` (in cosines) of it.
struct ConeGoal {
  Eigen::Vector3d axis, direction;
  double cosine, margin;
};
struct PostureGoal {
  JointVector q, velocity;
};
// Every joint stays inside its limits; active within `margin` rad or m of them.
struct JointLimitGoal {
  double margin;
};
// The frame's origin lies on the plane direction . x = height.
struct PlaneGoal {
  Eigen::Vector3d direction;
  double height;
};
// The frame's origin stays `distance` away from a shape; active within `margin` beyond it.
struct ClearanceGoal {
  Shape shape;
  double distance, margin;
};

using Goal = std::variant<PoseGoal, PositionGoal, DirectionGoal, ConeGoal, PostureGoal,
                          JointLimitGoal, PlaneGoal, ClearanceGoal>;

struct ArmTask {
  Goal goal;
  Frame frame;                 // of those that have one
  double gain = 1.0;           // 1/s: the error's rate of decay
  double damping_ratio = 1.0;  // of the second-order decay, accelerations only
};

constexpr int kMaxTasks = 12;

struct TaskStack {
  Chain chain;
  std::vector<ArmTask> tasks;  // the highest priority first
  MotionLimits limits;
  PriorityScheme scheme = PriorityScheme::kForward;
  // 1/s: accelerations unconstrained by tasks slow the joints down at this rate.
  double rest_damping = 10.0;
};

// One value per task. error: m and rad, rotations weighted by kOrientationWeight; for unilateral
// tasks the violation. residual: difference between the motion and the task's demand, in the units
// of the error per s or s^2. bounded: a limit or a higher task prevents the demanded motion.
struct TaskReport {
  double error = 0.0, residual = 0.0, activation = 0.0;
  bool bounded = false;
};

struct StackMotion {
  JointVector motion;
  std::array<TaskReport, kMaxTasks> reports;
};

// Throws std::invalid_argument if the sizes of a stack disagree.
void check_sizes(const TaskStack& stack);

// Workspace of a solve: repeated solves do not allocate.
struct StackWorkspace {
  explicit StackWorkspace(const TaskStack& stack);

  BodyMotions bodies;
  std::vector<Level> levels;
  std::vector<int> owner;  // of a level, the task
};

using JointsIn = const VectorRef&;

// These throw std::invalid_argument unless q and qd (joints,) fit the stack and dt is positive.
// Velocities for the next interval dt; qd may be empty (see velocity_box).
StackMotion stack_velocity(const TaskStack& stack, JointsIn q, JointsIn qd, double dt,
                           StackWorkspace& workspace);

// Accelerations for the next interval dt.
StackMotion stack_acceleration(const TaskStack& stack, JointsIn q, JointsIn qd, double dt,
                               StackWorkspace& workspace);

// q and qd an interval later. Velocities are taken at the interval's middle, which leaves an error
// of third order in dt, so that the null space's motion does not move the tool.
struct StackStep {
  JointVector q, qd;
  StackMotion solution;
};
StackStep stack_step(const TaskStack& stack, JointsIn q, JointsIn qd, double dt,
                     StackWorkspace& workspace);

}  // namespace leadthrough
