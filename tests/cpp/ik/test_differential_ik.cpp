#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

#include "arm/robots.hpp"
#include "base/allocations.hpp"
#include "base/cases.hpp"
#include "leadthrough/ik/differential_ik.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace leadthrough::differential_ik_tests {

namespace {

DifferentialIk crooked_solver() {
  const auto robot = std::get<urdf::Robot>(urdf::parse(test::crooked_arm()));
  DifferentialIk solver;
  solver.chain = std::get<Chain>(make_chain(robot, "l0", "l9"));
  const int n = solver.chain.joints();
  solver.limits = {solver.chain.lower, solver.chain.upper, JointVector::Constant(n, 1.5),
                   JointVector::Constant(n, 8.0)};
  solver.posture = middle(solver.chain);
  return solver;
}

IkTarget pose_at(const Chain& chain, const JointVector& q) {
  const Transform pose = forward_kinematics(chain, q.data());
  return {pose.position, pose.rotation};
}

// Runs to rest and checks every step against the limits.
DifferentialStep run(const DifferentialIk& solver, const IkTarget& target, const JointVector& start,
                     int steps) {
  const int n = solver.chain.joints();
  DifferentialStep now{start, JointVector::Zero(n)};
  for (int k = 0; k < steps; ++k) {
    const DifferentialStep next = differential_step(solver, target, Vector6::Zero(), now.q, now.qd);
    const JointVector change = (next.qd - now.qd) / solver.dt;
    EXPECT_TRUE((next.q.array() >= solver.limits.lower.array()).all());
    EXPECT_TRUE((next.q.array() <= solver.limits.upper.array()).all());
    EXPECT_TRUE((next.qd.array().abs() <= solver.limits.velocity.array() + 1e-12).all());
    EXPECT_TRUE((change.array().abs() <= solver.limits.acceleration.array() + 1e-9).all());
    EXPECT_LT((next.q - now.q - solver.dt * next.qd).cwiseAbs().maxCoeff(), 1e-12);
    now = next;
  }
  return now;
}

}  // namespace

TEST(DifferentialIk, ReachesTargetsInsideTheLimits) {
  const DifferentialIk solver = crooked_solver();
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(-0.6, 0.6);
  for (int repeat = 0; repeat < test::cases(20, 4); ++repeat) {
    JointVector start = JointVector::Constant(7, 0.3), goal = start;
    start[0] = goal[0] = 0.17;
    for (Eigen::Index i = 1; i < 7; ++i) goal[i] += uniform(generator);
    const IkTarget target = pose_at(solver.chain, goal);
    const DifferentialStep end = run(solver, target, start, 4000);
    EXPECT_LT(end.position_error, 1e-6) << repeat;
    EXPECT_LT(end.orientation_error, 1e-6) << repeat;
  }
}

TEST(DifferentialIk, UnreachableTargetsBringTheArmToRest) {
  const DifferentialIk solver = crooked_solver();
  const IkTarget far{Eigen::Vector3d(4.0, 1.0, 0.5), Eigen::Matrix3d::Identity()};
  const DifferentialStep end = run(solver, far, JointVector::Constant(7, 0.2), 8000);
  EXPECT_TRUE(end.q.allFinite());
  EXPECT_LT(end.qd.cwiseAbs().maxCoeff(), 0.1);
}

TEST(DifferentialIk, AMotionTooFastToStopBrakesAtTheLimit) {
  const DifferentialIk solver = crooked_solver();
  JointVector q = JointVector::Constant(7, 0.3), qd = JointVector::Zero(7);
  q[1] = solver.limits.upper[1] - 1e-3;
  qd[1] = 1.0;
  const IkTarget target = pose_at(solver.chain, JointVector::Constant(7, 0.3));
  const DifferentialStep next = differential_step(solver, target, Vector6::Zero(), q, qd);
  EXPECT_NEAR(next.qd[1], 1.0 - solver.dt * solver.limits.acceleration[1], 1e-12);
}

TEST(DifferentialIk, WrongSizesAndNumbersThrow) {
  DifferentialIk solver = crooked_solver();
  const JointVector q = JointVector::Constant(7, 0.1), three = JointVector::Zero(3);
  const JointVector nan = JointVector::Constant(7, std::nan(""));
  const IkTarget target = pose_at(solver.chain, q);
  const auto step = [&](const IkTarget& to, const JointVector& at, const JointVector& rate) {
    return differential_step(solver, to, Vector6::Zero(), at, rate);
  };
  EXPECT_NO_THROW(step(target, q, q));
  EXPECT_THROW(step(target, three, q), std::invalid_argument);
  EXPECT_THROW(step(target, q, three), std::invalid_argument);
  EXPECT_THROW(step(target, nan, q), std::invalid_argument);
  EXPECT_THROW(step({Eigen::Vector3d::Constant(std::nan("")), {}}, q, q), std::invalid_argument);
  EXPECT_NO_THROW(check_sizes(solver));
  solver.posture = three;
  EXPECT_THROW(check_sizes(solver), std::invalid_argument);
}

TEST(DifferentialIk, StepsDoNotAllocate) {
  const DifferentialIk solver = crooked_solver();
  const JointVector q = JointVector::Constant(7, 0.1), qd = JointVector::Constant(7, 0.2);
  IkTarget target = pose_at(solver.chain, JointVector::Constant(7, 0.3));
  const std::size_t before = test::allocations();
  for (int k = 0; k < 10; ++k) differential_step(solver, target, Vector6::Zero(), q, qd);
  target.rotation.reset();
  differential_step(solver, target, Vector6::Zero(), q, qd);
  EXPECT_EQ(test::allocations(), before);
}

TEST(DifferentialIk, TheCounterSeesAllocations) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const std::size_t before = test::allocations();
  void* volatile memory = std::malloc(8);
  std::free(memory);
  EXPECT_GT(test::allocations(), before);
#endif
}

}  // namespace leadthrough::differential_ik_tests
