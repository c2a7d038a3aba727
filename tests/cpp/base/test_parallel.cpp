// Whatever runs on several threads, also under ThreadSanitizer: the same bits as on one.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "arm/robots.hpp"
#include "base/allocations.hpp"
#include "leadthrough/base/parallel.hpp"
#include "leadthrough/collision/check.hpp"
#include "leadthrough/field/eikonal.hpp"
#include "leadthrough/ik/arm_tasks.hpp"
#include "leadthrough/ik/differential_ik.hpp"
#include "leadthrough/ik/solve.hpp"

namespace leadthrough::parallel_tests {

namespace {

Rows waving(int count, int joints) {
  Rows q(count, joints);
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < joints; ++k) q(i, k) = 0.17 + 0.1 * std::sin(0.1 * (k + 1) * i + k);
  return q;
}

// Calls `work` here and on four threads at once.
template <typename Work>
void expect_equal_results(const Work& work) {
  const JointVector alone = work();
  std::vector<JointVector> results(4);
  std::vector<std::thread> threads;
  for (JointVector& each : results) threads.emplace_back([&work, &each] { each = work(); });
  for (std::thread& thread : threads) thread.join();
  for (const JointVector& each : results) EXPECT_EQ(each, alone);
}

MotionLimits limits_of(const Chain& chain) {
  return {chain.lower, chain.upper, JointVector::Constant(chain.joints(), 1.5),
          JointVector::Constant(chain.joints(), 8.0)};
}

}  // namespace

TEST(Threads, EachIndexIsCalledOnce) {
  std::vector<int> calls(1000);
  for_each_index(calls.size(), 4, [&](std::size_t i) { ++calls[i]; });
  EXPECT_EQ(calls, std::vector<int>(1000, 1));
}

TEST(Threads, AllWorkIsDoneWithoutMemoryForThreads) {
  for (int left = 0; left < 6; ++left) {
    std::vector<int> calls(100);
    const test::NoMemory none(left);
    for_each_index(calls.size(), 4, [&](std::size_t i) { ++calls[i]; });
    EXPECT_EQ(std::count(calls.begin(), calls.end(), 1), 100);
  }
}

TEST(Threads, AnExceptionComesOutAndStopsTheRest) {
  std::atomic<std::size_t> calls{0};
  EXPECT_THROW(for_each_index(1000000, 4,
                              [&](std::size_t i) {
                                ++calls;
                                // Or the rest would be done before a thread that is interrupted.
                                std::this_thread::sleep_for(std::chrono::microseconds(20));
                                if (i == 10) throw std::runtime_error("ten");
                              }),
               std::runtime_error);
  EXPECT_LT(calls, 1000000U);
}

TEST(Threads, AnInterruptEndsTheWorkOfHelpersWhileTheCallerWaits) {
  const Interruptible interruptible([] { return true; });
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<bool> begun{false};
  const auto work = [&](std::size_t) {
    while (std::this_thread::get_id() == caller && !begun) std::this_thread::yield();
    for (begun = true; std::this_thread::get_id() != caller;) check_interrupt();
  };
  EXPECT_THROW(for_each_index(2, 2, work), Interrupted);
}

TEST(Threads, AnInterruptEndsOnlyWhatIsInterruptible) {
  const auto check_often = [] {
    for (int i = 0; i < 1'000'000; ++i) check_interrupt();
  };
  {
    const Interruptible outer([] { return false; });
    const Interruptible inner([] { return true; });
    EXPECT_THROW(while (true) check_interrupt(), Interrupted);
  }
  EXPECT_NO_THROW(check_often());
}

TEST(Threads, ReportsOfCollisionsHaveTheSameBits) {
  const std::string bar = "<collision><geometry><box size='0.1 0.1 0.3'/></geometry></collision>";
  std::string text = test::crooked_arm();
  for (const std::string name : {"'l2'>", "'l5'>", "'l9'>"})
    text.insert(text.find(name) + name.size(), bar);
  const auto robot = std::get<urdf::Robot>(urdf::parse(text));
  const auto model = make_collision_model(robot, test::crooked_chain(), "l0", "l9", {}, {});
  const Transform ahead{Eigen::Matrix3d::Identity(), {0.4, 0.2, 0.6}};
  const auto scene = against(model, {{box({0.2, 0.2, 0.2}), ahead}});
  const Rows q = waving(400, 7);
  const MotionReport one = check_motion(scene, q, {0.01, 1e-3, 1});
  const MotionReport four = check_motion(scene, q, {0.01, 1e-3, 4});
  for (std::size_t i = 0; i < one.samples.size(); ++i)
    EXPECT_EQ(one.samples[i].distance, four.samples[i].distance);
  EXPECT_EQ(one.closest.nearest.distance, four.closest.nearest.distance);
  EXPECT_EQ(one.closest.sample, four.closest.sample);
  ASSERT_TRUE(one.first);
  EXPECT_EQ(one.first->sample, four.first->sample);
}

TEST(Threads, MarchesHaveTheSameBits) {
  const Grid grid{{9, 14, 11}, {1.0, 1.0, 1.0}};
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(0.2, 1.0);
  std::vector<std::vector<double>> speeds(12, std::vector<double>(grid.size()));
  std::vector<MarchProblem<double>> problems;
  for (auto& speed : speeds) {
    for (double& each : speed) each = uniform(generator) < 0.35 ? 0.0 : uniform(generator);
    speed[5] = 1.0;
    problems.push_back({speed.data(), {{5, 0.0}}});
  }
  for (const int order : {1, 2}) {
    const auto one = march_batch(grid, problems, {order, 4.0}, 1);
    EXPECT_EQ(march_batch(grid, problems, {order, 4.0}, 4), one);
    EXPECT_EQ(march_batch(grid, problems, {order, 4.0}, 64), one);
  }
}

TEST(Threads, InverseKinematicsHasTheSameBits) {
  const Chain chain = test::crooked_chain();
  const Poses targets = forward_kinematics_batch(chain, 5.0 * waving(64, 7));
  const Rows starts = waving(64, 7);
  const auto one = solve_ik_batch(chain, targets.positions, targets.orientations, starts, {}, 1);
  const auto many = solve_ik_batch(chain, targets.positions, targets.orientations, starts, {}, 4);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].q, many[i].q);
    EXPECT_EQ(one[i].iterations, many[i].iterations);
  }
}

TEST(Threads, ShareADifferentialIk) {
  DifferentialIk solver;
  solver.chain = test::crooked_chain();
  solver.limits = limits_of(solver.chain);
  solver.posture = middle(solver.chain);
  const JointVector start = JointVector::Constant(7, 0.3), goal = JointVector::Constant(7, 0.1);
  const Transform pose = forward_kinematics(solver.chain, goal.data());
  expect_equal_results([&] {
    DifferentialStep now{start, JointVector::Zero(7)};
    for (int k = 0; k < 300; ++k)
      now =
          differential_step(solver, {pose.position, pose.rotation}, Vector6::Zero(), now.q, now.qd);
    return now.q;
  });
}

TEST(Threads, ShareATaskStack) {
  const Chain chain = test::crooked_chain();
  const JointVector start = JointVector::Constant(7, 0.1), rest = JointVector::Zero(7);
  const Transform pose = forward_kinematics(chain, rest.data());
  TaskStack stack{chain, {}, {}, PriorityScheme::kReverse, 10.0};
  stack.tasks = {
      {JointLimitGoal{0.2}, {}, 5.0, 1.0},
      {PoseGoal{pose.position, pose.rotation, Vector6::Zero()}, tip_frame(chain), 5.0, 1.0},
      {PostureGoal{start, rest}, {}, 5.0, 1.0}};
  stack.limits = limits_of(chain);
  expect_equal_results([&] {
    StackWorkspace workspace(stack);
    StackStep now{start, rest, {}};
    for (int k = 0; k < 200; ++k) now = stack_step(stack, now.q, now.qd, 1e-3, workspace);
    return now.q;
  });
}

}  // namespace leadthrough::parallel_tests
