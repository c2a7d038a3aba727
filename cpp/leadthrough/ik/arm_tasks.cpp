#include "leadthrough/ik/arm_tasks.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/ik/damped_step.hpp"

namespace leadthrough {

namespace {

// 0 from `margin` on, 1 below half of it, smooth in between: the inner half is the guarantee's.
double activation(double slack, double margin) {
  const double x = std::clamp(2.0 * (margin - slack) / margin, 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}

// An arm at rest or in motion, and the levels of its tasks.
class Scene {
 public:
  // order: 1 for velocities, 2 for accelerations. dt: s; nothing decays in less. lead: s by which
  // moving goals are ahead.
  Scene(const TaskStack& stack, const double* q, const double* qd, int order, double dt,
        double lead, StackWorkspace& workspace)
      : stack_(stack),
        q_(q),
        qd_(qd, stack.chain.joints()),
        order_(order),
        dt_(dt),
        lead_(lead),
        workspace_(workspace) {
    body_motions(stack.chain, q, qd, workspace.bodies);
    workspace.levels.clear();
    workspace.owner.clear();
  }

  void add_tasks() {
    for (const ArmTask& task : stack_.tasks) {
      task_ = &task;
      std::visit([this](const auto& goal) { fill(goal); }, task.goal);
      ++index_;
    }
  }

  // Brings the joints to rest in the null space of all tasks.
  void add_rest(double rate) {
    const int n = stack_.chain.joints();
    index_ = -1;
    Level& level = next(n);
    level.jacobian.setIdentity();
    level.wanted = -rate * qd_;
  }

 private:
  void fill(const PoseGoal& goal) {
    const BodyMotion frame = frame_motion(workspace_.bodies, task_->frame);
    Level& level = next(6);
    level.jacobian = frame_jacobian(stack_.chain, workspace_.bodies, task_->frame);
    level.jacobian.bottomRows<3>() *= kOrientationWeight;
    Vector6 error, bias, feed = goal.twist;
    const Eigen::Vector3d turn = rotation_vector(goal.rotation * frame.rotation.transpose());
    error << goal.position - frame.position, kOrientationWeight * turn;
    bias << frame.acceleration, kOrientationWeight * frame.angular_acceleration;
    feed.tail<3>() *= kOrientationWeight;
    reach(level, error + lead_ * feed, feed, bias);
  }

  void fill(const PositionGoal& goal) {
    const BodyMotion frame = frame_motion(workspace_.bodies, task_->frame);
    Level& level = next(3);
    level.jacobian = frame_jacobian(stack_.chain, workspace_.bodies, task_->frame).topRows<3>();
    reach(level, goal.position - frame.position + lead_ * goal.velocity, goal.velocity,
          frame.acceleration);
  }

  void fill(const DirectionGoal& goal) {
    const Pointer pointer = point(goal.axis);
    Level& level = next(3);
    level.jacobian = kOrientationWeight * pointer.jacobian;
    // The logarithm on the sphere, along the great circle; from the opposite point along any.
    const double cosine = pointer.axis.dot(goal.direction);
    const Eigen::Vector3d across = goal.direction - cosine * pointer.axis;
    const double sine = across.norm();
    constexpr double kOpposite = 1e-9;  // rad
    const Eigen::Vector3d axis = sine > kOpposite ? Eigen::Vector3d(across / sine)
                                 : cosine > 0.0   ? Eigen::Vector3d::Zero()
                                                  : pointer.axis.unitOrthogonal();
    const Eigen::Vector3d error = std::atan2(sine, cosine) * axis;
    // The component along the axis only preserves its length: no joint can or should change it.
    const Eigen::Vector3d bias = pointer.bias - pointer.axis.dot(pointer.bias) * pointer.axis;
    reach(level, kOrientationWeight * error, Eigen::Vector3d::Zero(), kOrientationWeight * bias);
  }

  void fill(const ConeGoal& goal) {
    const Pointer pointer = point(goal.axis);
    keep(goal.direction.transpose() * pointer.jacobian,
         pointer.axis.dot(goal.direction) - goal.cosine, goal.margin,
         goal.direction.dot(pointer.bias));
  }

  void fill(const PostureGoal& goal) {
    const int n = stack_.chain.joints();
    Level& level = next(n);
    level.jacobian.setIdentity();
    const Eigen::Map<const Eigen::VectorXd> q(q_, n);
    reach(level, goal.q - q + lead_ * goal.velocity, goal.velocity, JointVector::Zero(n));
  }

  void fill(const JointLimitGoal& goal) {
    const Chain& chain = stack_.chain;
    for (int i = 0; i < chain.joints(); ++i) {
      // A joint is never near both of its limits.
      const double margin = std::min(goal.margin, 0.25 * (chain.upper[i] - chain.lower[i]));
      const double above = q_[i] - chain.lower[i], below = chain.upper[i] - q_[i];
      const double slack = std::min(above, below);
      if (!(margin > 0.0) || slack >= margin) continue;
      TaskMatrix row = TaskMatrix::Zero(1, chain.joints());
      row(0, i) = above < below ? 1.0 : -1.0;
      keep(row, slack, margin, 0.0);
    }
  }

  void fill(const PlaneGoal& goal) {
    const BodyMotion frame = frame_motion(workspace_.bodies, task_->frame);
    Level& level = next(1);
    level.jacobian = goal.direction.transpose() *
                     frame_jacobian(stack_.chain, workspace_.bodies, task_->frame).topRows<3>();
    reach(level, JointVector::Constant(1, goal.height - goal.direction.dot(frame.position)),
          JointVector::Zero(1), JointVector::Constant(1, goal.direction.dot(frame.acceleration)));
  }

  // The curvature of the distance is left out of the bias: a convex shape's only adds to it.
  void fill(const ClearanceGoal& goal) {
    const BodyMotion frame = frame_motion(workspace_.bodies, task_->frame);
    const SignedDistance found = signed_distance(goal.shape, frame.position);
    keep(found.gradient.transpose() *
             frame_jacobian(stack_.chain, workspace_.bodies, task_->frame).topRows<3>(),
         found.distance - goal.distance, goal.margin, found.gradient.dot(frame.acceleration));
  }

  struct Pointer {
    Eigen::Vector3d axis;  // base frame
    Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMaxJoints> jacobian;
    Eigen::Vector3d bias;
  };

  // An axis that the frame carries: its rate of change is angular velocity x axis.
  Pointer point(const Eigen::Vector3d& axis_in_frame) const {
    const BodyMotion frame = frame_motion(workspace_.bodies, task_->frame);
    const Eigen::Vector3d axis = frame.rotation * axis_in_frame;
    const FrameJacobian whole = frame_jacobian(stack_.chain, workspace_.bodies, task_->frame);
    Pointer pointer{axis, {}, frame.angular_acceleration.cross(axis)};
    pointer.jacobian.resize(3, whole.cols());
    for (Eigen::Index i = 0; i < whole.cols(); ++i)
      pointer.jacobian.col(i) = whole.col(i).tail<3>().cross(axis);
    pointer.bias += frame.angular_velocity.cross(frame.angular_velocity.cross(axis));
    return pointer;
  }

  Level& next(int rows) {
    workspace_.levels.emplace_back();
    workspace_.owner.push_back(index_);
    Level& level = workspace_.levels.back();
    level.jacobian.resize(rows, stack_.chain.joints());
    return level;
  }

  // An error that should decay while the goal moves at `feed`.
  void reach(Level& level, const JointVector& error, const JointVector& feed,
             const JointVector& bias) {
    const double rate = gain();
    level.wanted = feed + rate * error;
    if (order_ == 2)
      level.wanted = rate * rate * error - bias +
                     2.0 * task_->damping_ratio * rate * (feed - level.jacobian.lazyProduct(qd_));
    note_error(error.norm(), 1.0);
  }

  // A slack that may only decay (Faverjon and Tournassoud 1987, the velocity damper).
  void keep(const TaskMatrix& row, double slack, double margin, double bias) {
    const double share = activation(slack, margin);
    note_error(std::max(-slack, 0.0), share);
    if (!(share > 0.0)) return;
    const double rate = gain();
    Level& level = next(1);
    level.jacobian = row;
    level.unilateral = true;
    level.activation = share;
    const double wanted = order_ == 1 ? -rate * slack
                                      : -rate * rate * slack - bias -
                                            2.0 * task_->damping_ratio * rate * row.row(0).dot(qd_);
    level.wanted = JointVector::Constant(1, wanted);
    level.relief = margin * (order_ == 1 ? rate : rate * rate);
  }

  // Above these the sampled loop would overshoot.
  double gain() const {
    const double fastest = order_ == 1 ? 1.0 : 0.5 / std::max(task_->damping_ratio, 1.0);
    return std::min(task_->gain, fastest / dt_);
  }

  void note_error(double error, double share) {
    TaskReport& report = reports[static_cast<std::size_t>(index_)];
    report.error = std::max(report.error, error);
    report.activation = std::max(report.activation, share);
  }

 public:
  std::array<TaskReport, kMaxTasks> reports{};

 private:
  const TaskStack& stack_;
  const double* q_;
  Eigen::Map<const Eigen::VectorXd> qd_;
  int order_;
  double dt_, lead_;
  StackWorkspace& workspace_;
  int index_ = 0;
  const ArmTask* task_ = nullptr;
};

void judge(const StackWorkspace& workspace, StackMotion& answer) {
  for (std::size_t i = 0; i < workspace.levels.size(); ++i) {
    if (workspace.owner[i] < 0) continue;
    const Level& level = workspace.levels[i];
    TaskReport& report = answer.reports[static_cast<std::size_t>(workspace.owner[i])];
    double residual = 0.0;
    if (level.unilateral) {
      const double off = level.wanted[0] - level.jacobian.row(0).dot(answer.motion);
      residual = level.activation * std::max(off, 0.0);
    } else {
      residual = (level.wanted - level.jacobian.lazyProduct(answer.motion)).norm();
    }
    report.residual = std::max(report.residual, residual);
    report.bounded = report.bounded || level.bounded;
  }
}

StackMotion solve(const TaskStack& stack, const Scene& scene, const MotionBox& box,
                  double quickness, StackWorkspace& workspace) {
  StackMotion answer{resolve(workspace.levels, box, stack.scheme, quickness), scene.reports};
  judge(workspace, answer);
  return answer;
}

StackMotion velocity_in(const TaskStack& stack, const double* q, const MotionBox& box, double dt,
                        double lead, StackWorkspace& workspace) {
  const JointVector still = JointVector::Zero(stack.chain.joints());
  Scene scene(stack, q, still.data(), 1, dt, lead, workspace);
  scene.add_tasks();
  return solve(stack, scene, box, kVelocityQuickness, workspace);
}

void check_state(const TaskStack& stack, JointsIn q, JointsIn qd, double dt) {
  check_argument(q.size() == stack.chain.joints(), "q: one number a joint");
  check_argument(qd.size() == q.size(), "qd: one number a joint");
  check_argument(dt > 0.0 && std::isfinite(dt), "dt: a positive time");
}

void check_task(const ArmTask& task, const Chain& chain) {
  check_argument(task.frame.moving >= 0 && task.frame.moving <= chain.moving,
                 "tasks: frames that joints of the chain move");
  if (const auto* posture = std::get_if<PostureGoal>(&task.goal))
    check_argument(
        posture->q.size() == chain.joints() && posture->velocity.size() == chain.joints(),
        "tasks: postures of one number a joint");
  else if (!std::holds_alternative<JointLimitGoal>(task.goal))
    check_argument(task.frame.moving > 0, "tasks: frames that move");
}

}  // namespace

void check_sizes(const TaskStack& stack) {
  const MotionLimits& limits = stack.limits;
  for (const JointVector* each :
       {&limits.lower, &limits.upper, &limits.velocity, &limits.acceleration})
    check_argument(each->size() == stack.chain.joints(), "limits: one number a joint");
  check_argument(stack.tasks.size() <= static_cast<std::size_t>(kMaxTasks),
                 "tasks: at most kMaxTasks");
  for (const ArmTask& task : stack.tasks) check_task(task, stack.chain);
  // It may fill a level a joint.
  check_argument(std::count_if(stack.tasks.begin(), stack.tasks.end(),
                               [](const ArmTask& task) {
                                 return std::holds_alternative<JointLimitGoal>(task.goal);
                               }) <= 1,
                 "tasks: at most one of joint limits");
}

StackWorkspace::StackWorkspace(const TaskStack& stack) {
  const auto most = stack.tasks.size() + static_cast<std::size_t>(stack.chain.joints()) + 1;
  levels.reserve(most);
  owner.reserve(most);
}

StackMotion stack_velocity(const TaskStack& stack, JointsIn q, JointsIn qd, double dt,
                           StackWorkspace& workspace) {
  const bool known = qd.size() > 0;
  check_state(stack, q, known ? qd : q, dt);
  const MotionBox box = velocity_box(stack.limits, q.data(), known ? qd.data() : nullptr, dt);
  return velocity_in(stack, q.data(), box, dt, 0.0, workspace);
}

StackMotion stack_acceleration(const TaskStack& stack, JointsIn q, JointsIn qd, double dt,
                               StackWorkspace& workspace) {
  check_state(stack, q, qd, dt);
  const MotionBox box = acceleration_box(stack.limits, q.data(), qd.data(), dt);
  Scene scene(stack, q.data(), qd.data(), 2, dt, 0.0, workspace);
  scene.add_tasks();
  scene.add_rest(std::min(stack.rest_damping, 1.0 / dt));
  return solve(stack, scene, box, kAccelerationQuickness, workspace);
}

StackStep stack_step(const TaskStack& stack, JointsIn q, JointsIn qd, double dt,
                     StackWorkspace& workspace) {
  check_state(stack, q, qd, dt);
  const MotionBox box = velocity_box(stack.limits, q.data(), qd.data(), dt);
  StackMotion start = velocity_in(stack, q.data(), box, dt, 0.0, workspace);
  const JointVector halfway = q + 0.5 * dt * start.motion;
  StackMotion middle = velocity_in(stack, halfway.data(), box, dt, 0.5 * dt, workspace);
  middle.motion = middle.motion.cwiseMax(box.lower).cwiseMin(box.upper);
  const JointVector lower = stack.limits.lower.cwiseMin(q);
  const JointVector upper = stack.limits.upper.cwiseMax(q);
  const JointVector q_next = (q + dt * middle.motion).cwiseMax(lower).cwiseMin(upper);
  return {q_next, middle.motion, middle};
}

}  // namespace leadthrough
