#include <gtest/gtest.h>

#include <random>
#include <stdexcept>
#include <thread>

#include "arm/robots.hpp"
#include "base/allocations.hpp"
#include "base/cases.hpp"
#include "base/dense.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/ik/arm_tasks.hpp"
#include "leadthrough/ik/task_priority.hpp"

namespace leadthrough::task_priority_tests {

namespace {

class Random {
 public:
  explicit Random(unsigned seed) : generator_(seed) {}
  double normal() { return normal_(generator_); }
  int whole(int lowest, int highest) {
    return std::uniform_int_distribution<int>(lowest, highest)(generator_);
  }
  Eigen::MatrixXd matrix(int rows, int columns) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [this] { return normal(); });
  }

 private:
  std::mt19937 generator_;
  std::normal_distribution<double> normal_;
};

Level level(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& wanted) {
  Level made;
  made.jacobian = jacobian;
  made.wanted = wanted;
  return made;
}

// Any rank, and now and then a row that (nearly) repeats one of a level above.
std::vector<Level> random_stack(Random& random, int joints) {
  std::vector<Level> levels;
  const int count = random.whole(2, 6);
  for (int i = 0; i < count; ++i) {
    const int rows = random.whole(1, 6), rank = random.whole(0, rows);
    Eigen::MatrixXd jacobian = random.matrix(rows, joints);
    if (random.whole(0, 2) == 0) jacobian = random.matrix(rows, rank) * random.matrix(rank, joints);
    if (i > 0 && random.whole(0, 2) == 0)
      jacobian.row(0) = levels[0].jacobian.row(0) +
                        std::pow(10.0, random.whole(-15, -1)) * random.matrix(1, joints);
    levels.push_back(level(jacobian, random.matrix(rows, 1)));
  }
  return levels;
}

MotionBox unbounded(int joints) {
  return {JointVector::Constant(joints, -kInfinity), JointVector::Constant(joints, kInfinity)};
}

MotionBox random_box(Random& random, int joints) {
  return {-random.matrix(joints, 1).cwiseAbs(), random.matrix(joints, 1).cwiseAbs()};
}

// Siciliano and Slotine's recursion as it is printed.
Eigen::VectorXd by_pseudo_inverses(const std::vector<Level>& levels, int joints) {
  Eigen::MatrixXd projector = Eigen::MatrixXd::Identity(joints, joints);
  Eigen::VectorXd motion = Eigen::VectorXd::Zero(joints);
  for (const Level& each : levels) {
    const Eigen::MatrixXd reduced = each.jacobian * projector;
    const Eigen::MatrixXd inverse = test::pseudo_inverse(reduced);
    motion += inverse * (each.wanted - each.jacobian * motion);
    projector -= inverse * reduced;
  }
  return motion;
}

TaskStack every_task(const Chain& chain, PriorityScheme scheme) {
  const JointVector q = JointVector::Constant(chain.joints(), 0.2);
  const Transform pose = forward_kinematics(chain, q.data());
  const Frame tip = tip_frame(chain);
  const Frame elbow{4, {}};
  const Shape ball{Eigen::Matrix3d::Identity(), pose.position + Eigen::Vector3d(0.0, 0.15, 0.0),
                   sphere(0.1)};
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ(), ahead = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  TaskStack stack{chain, {}, {}, scheme, 10.0};
  stack.tasks = {
      {JointLimitGoal{0.2}, {}, 5.0, 1.0},
      {ClearanceGoal{ball, 0.02, 0.1}, tip, 5.0, 1.0},
      {ConeGoal{up, ahead, -0.5, 0.8}, tip, 5.0, 1.0},
      {PositionGoal{pose.position + Eigen::Vector3d(0.1, 0.1, 0.0), zero}, tip, 5.0, 1.0},
      {DirectionGoal{up, pose.rotation.col(0)}, tip, 5.0, 1.0},
      {PlaneGoal{up, 0.5}, elbow, 5.0, 1.0},
      {PoseGoal{pose.position, pose.rotation, Vector6::Zero()}, tip, 5.0, 1.0},
      {PostureGoal{q, JointVector::Zero(chain.joints())}, {}, 5.0, 1.0},
  };
  stack.limits = {chain.lower, chain.upper, JointVector::Constant(chain.joints(), 1.5),
                  JointVector::Constant(chain.joints(), 10.0)};
  return stack;
}

}  // namespace

TEST(TaskPriority, ALowerLevelNeverDisturbsAHigherOne) {
  Random random(1);
  for (int repeat = 0; repeat < test::cases(3000, 500); ++repeat) {
    const int joints = random.whole(3, kMaxJoints);
    std::vector<Level> levels = random_stack(random, joints);
    const MotionBox box = repeat % 2 == 0 ? unbounded(joints) : random_box(random, joints);
    std::vector<Level> without(levels.begin(), levels.end() - 1);
    for (const auto scheme : {PriorityScheme::kForward, PriorityScheme::kReverse}) {
      const JointVector all = resolve(levels, box, scheme);
      const JointVector fewer = resolve(without, box, scheme);
      ASSERT_TRUE(all.allFinite());
      for (const Level& higher : without)
        ASSERT_LT((higher.jacobian * (all - fewer)).cwiseAbs().maxCoeff(), 1e-9) << repeat;
    }
  }
}

TEST(TaskPriority, RegularStacksAgreeWithThePseudoInverses) {
  Random random(2);
  for (int repeat = 0; repeat < 500; ++repeat) {
    std::vector<Level> levels;
    for (const int rows : {3, 1, 2})
      levels.push_back(level(random.matrix(rows, 8), random.matrix(rows, 1)));
    Eigen::MatrixXd whole(6, 8);
    whole << levels[0].jacobian, levels[1].jacobian, levels[2].jacobian;
    if (test::singular_values(whole)[5] < 0.5) continue;  // near-singular ones are damped
    const JointVector motion = resolve(levels, unbounded(8), PriorityScheme::kForward);
    EXPECT_LT((motion - by_pseudo_inverses(levels, 8)).norm(), 1e-8 * (1.0 + motion.norm()));
  }
}

TEST(TaskPriority, MotionStaysInsideTheBox) {
  Random random(3);
  for (int repeat = 0; repeat < test::cases(1000, 200); ++repeat) {
    const int joints = random.whole(3, kMaxJoints);
    std::vector<Level> levels = random_stack(random, joints);
    for (Level& each : levels) each.wanted *= 10.0;
    const MotionBox box = random_box(random, joints);
    for (const auto scheme : {PriorityScheme::kForward, PriorityScheme::kReverse}) {
      const JointVector motion = resolve(levels, box, scheme);
      ASSERT_TRUE((motion.array() >= box.lower.array()).all());
      ASSERT_TRUE((motion.array() <= box.upper.array()).all());
    }
  }
}

TEST(TaskPriority, ALevelThatFitsTheBoxIsMetExactly) {
  Random random(4);
  for (int repeat = 0; repeat < 1000; ++repeat) {
    const MotionBox box = random_box(random, 7);
    JointVector inside(7);
    for (Eigen::Index i = 0; i < 7; ++i)
      inside[i] = 0.9 * (random.whole(0, 1) == 0 ? box.lower[i] : box.upper[i]);
    const Eigen::MatrixXd jacobian = random.matrix(4, 7);
    std::vector<Level> levels = {level(jacobian, jacobian * inside)};
    const JointVector motion = resolve(levels, box, PriorityScheme::kForward);
    EXPECT_LT((jacobian * (motion - inside)).norm(), 1e-5) << repeat;
  }
}

TEST(TaskPriority, AUnilateralLevelIsOneSidedAndContinuousInItsActivation) {
  Random random(5);
  for (int repeat = 0; repeat < test::cases(40, 8); ++repeat) {
    std::vector<Level> levels;
    for (int i = 0; i < 2; ++i) {
      levels.push_back(level(random.matrix(1, 7), random.matrix(1, 1)));
      levels.back().unilateral = true;
    }
    levels.push_back(level(random.matrix(4, 7), random.matrix(4, 1)));
    const MotionBox box = {JointVector::Constant(7, -30.0), JointVector::Constant(7, 30.0)};
    for (const auto scheme : {PriorityScheme::kForward, PriorityScheme::kReverse}) {
      const JointVector full = resolve(levels, box, scheme);
      for (int i = 0; i < 2; ++i)
        EXPECT_GE(levels[static_cast<std::size_t>(i)].jacobian.row(0).dot(full),
                  levels[static_cast<std::size_t>(i)].wanted[0] - 1e-6);
      JointVector before;
      constexpr int kShares = 300;
      for (int k = 0; k <= kShares; ++k) {
        levels[0].activation = static_cast<double>(k) / kShares;
        const JointVector motion = resolve(levels, box, scheme);
        if (k > 0) {
          EXPECT_LT((motion - before).norm(), 0.5) << repeat << " " << k;
        }
        before = motion;
      }
    }
  }
}

TEST(TaskPriority, SchemesAgreeWhereEveryLevelIsFullyActive) {
  Random random(6);
  for (int repeat = 0; repeat < 300; ++repeat) {
    std::vector<Level> levels = random_stack(random, 7);
    const JointVector forward = resolve(levels, unbounded(7), PriorityScheme::kForward);
    const JointVector reverse = resolve(levels, unbounded(7), PriorityScheme::kReverse);
    EXPECT_LT((forward - reverse).norm(), 1e-12);
  }
}

TEST(TaskPriority, AlmostActiveReverseStacksApproachTheForwardOnes) {
  Random random(7);
  for (int repeat = 0; repeat < 100; ++repeat) {
    std::vector<Level> levels;
    for (const int rows : {2, 2, 2})
      levels.push_back(level(random.matrix(rows, 9), random.matrix(rows, 1)));
    const JointVector forward = resolve(levels, unbounded(9), PriorityScheme::kForward);
    for (Level& each : levels) each.activation = 1.0 - 1e-9;
    const JointVector reverse = resolve(levels, unbounded(9), PriorityScheme::kReverse);
    EXPECT_LT((forward - reverse).norm(), 1e-6 * (1.0 + forward.norm()));
  }
}

TEST(TaskPriority, BrakingSpeedIsTheFastestThatStopsInTime) {
  for (const double a : {0.5, 7.0}) {
    for (double distance = 0.0; distance < 0.3; distance += 0.00137) {
      constexpr double kStep = 0.01;
      const auto way = [&](double speed) {
        double sum = 0.0;
        for (; speed > 0.0; speed -= a * kStep) sum += speed * kStep;
        return sum;
      };
      const double speed = braking_speed(distance, a, kStep);
      EXPECT_LE(way(speed), distance + 1e-12);
      EXPECT_GT(way(speed + 1e-6), distance);
    }
  }
}

TEST(TaskPriority, JacobiansAndBiasesAreTheDerivativesOfTheFrame) {
  const Chain chain = test::crooked_chain();
  const int n = chain.joints();
  Random random(8);
  for (int repeat = 0; repeat < 20; ++repeat) {
    const JointVector q = 0.5 * random.matrix(n, 1), qd = random.matrix(n, 1);
    for (const Frame& frame :
         {tip_frame(chain), Frame{4, {Eigen::Matrix3d::Identity(), {0.1, 0.2, 0.3}}}}) {
      const auto at = [&](double time) {
        const JointVector moved = q + time * qd;
        BodyMotions bodies;
        body_motions(chain, moved.data(), qd.data(), bodies);
        return frame_motion(bodies, frame);
      };
      constexpr double kStep = 1e-5;
      const BodyMotion now = at(0.0), before = at(-kStep), after = at(kStep);
      EXPECT_LT(((after.position - before.position) / (2 * kStep) - now.velocity).norm(), 1e-7);
      EXPECT_LT(((after.velocity - before.velocity) / (2 * kStep) - now.acceleration).norm(), 1e-7);
      EXPECT_LT(((after.angular_velocity - before.angular_velocity) / (2 * kStep) -
                 now.angular_acceleration)
                    .norm(),
                1e-7);
      BodyMotions bodies;
      body_motions(chain, q.data(), qd.data(), bodies);
      Vector6 twist = frame_jacobian(chain, bodies, frame) * qd;
      EXPECT_LT((twist.head<3>() - now.velocity).norm(), 1e-12);
      EXPECT_LT((twist.tail<3>() - now.angular_velocity).norm(), 1e-12);
    }
  }
}

TEST(TaskPriority, SolvesDoNotAllocate) {
  const Chain chain = test::crooked_chain();
  const JointVector q = JointVector::Constant(chain.joints(), 0.1);
  const JointVector qd = JointVector::Constant(chain.joints(), 0.3);
  for (const auto scheme : {PriorityScheme::kForward, PriorityScheme::kReverse}) {
    const TaskStack stack = every_task(chain, scheme);
    StackWorkspace workspace(stack);
    const std::size_t before = test::allocations();
    for (int k = 0; k < 10; ++k) {
      stack_step(stack, q, qd, 1e-3, workspace);
      stack_acceleration(stack, q, qd, 1e-3, workspace);
    }
    EXPECT_EQ(test::allocations(), before);
  }
}

TEST(TaskPriority, ABoxWithoutMotionsThrows) {
  std::vector<Level> levels(1);
  levels[0].jacobian = Rows::Identity(2, 2);
  levels[0].wanted = Eigen::Vector2d::Ones();
  MotionBox box{JointVector::Zero(2), JointVector::Zero(2)};
  for (const PriorityScheme scheme : {PriorityScheme::kForward, PriorityScheme::kReverse}) {
    for (const double lower : {1.0, std::nan("")}) {
      box.lower[1] = lower;
      EXPECT_THROW(resolve(levels, box, scheme), std::invalid_argument);
    }
  }
}

TEST(TaskPriority, WrongSizesThrow) {
  const Chain chain = test::crooked_chain();
  TaskStack stack = every_task(chain, PriorityScheme::kForward);
  StackWorkspace workspace(stack);
  const JointVector q = JointVector::Constant(chain.joints(), 0.1), three = JointVector::Zero(3);
  EXPECT_NO_THROW(check_sizes(stack));
  EXPECT_NO_THROW(stack_velocity(stack, q, Eigen::VectorXd(), 1e-3, workspace));
  EXPECT_THROW(stack_velocity(stack, three, q, 1e-3, workspace), std::invalid_argument);
  EXPECT_THROW(stack_step(stack, q, three, 1e-3, workspace), std::invalid_argument);
  EXPECT_THROW(stack_acceleration(stack, q, Eigen::VectorXd(), 1e-3, workspace),
               std::invalid_argument);
  EXPECT_THROW(stack_step(stack, q, q, 0.0, workspace), std::invalid_argument);
  stack.tasks.push_back({PostureGoal{three, three}, {}, 5.0, 1.0});
  EXPECT_THROW(check_sizes(stack), std::invalid_argument);
  stack.tasks.back() = {JointLimitGoal{0.2}, {}, 5.0, 1.0};
  stack.tasks.push_back(stack.tasks.back());
  EXPECT_THROW(check_sizes(stack), std::invalid_argument);
  stack.tasks.assign(kMaxTasks + 1, {PostureGoal{q, q}, {}, 5.0, 1.0});
  EXPECT_THROW(check_sizes(stack), std::invalid_argument);
  stack.tasks.clear();
  stack.limits.velocity = three;
  EXPECT_THROW(check_sizes(stack), std::invalid_argument);
}

}  // namespace leadthrough::task_priority_tests
