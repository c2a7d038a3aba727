#include <gtest/gtest.h>

#include <random>

#include "arm/robots.hpp"
#include "leadthrough/ik/solve.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace leadthrough::solve_tests {

namespace {

Rows random_configurations(const Chain& chain, int count, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Rows q(count, chain.joints());
  for (Eigen::Index i = 0; i < q.rows(); ++i)
    for (Eigen::Index k = 0; k < q.cols(); ++k) {
      const double lower = std::max(chain.lower[k], -3.0), upper = std::min(chain.upper[k], 3.0);
      q(i, k) = lower + uniform(generator) * (upper - lower);
    }
  return q;
}

bool inside(const Chain& chain, const JointVector& q) {
  return (q.array() >= chain.lower.array()).all() && (q.array() <= chain.upper.array()).all();
}

}  // namespace

TEST(Ik, ReachesEveryReachableTargetInsideTheLimits) {
  const Chain chain = test::crooked_chain();
  const Poses targets = forward_kinematics_batch(chain, random_configurations(chain, 300, 1));
  const Rows starts = random_configurations(chain, 300, 2);
  for (const double nullspace_gain : {0.0, 1.0}) {
    IkOptions options;
    options.nullspace_gain = nullspace_gain;
    const auto results =
        solve_ik_batch(chain, targets.positions, targets.orientations, starts, options, 1);
    for (Eigen::Index i = 0; i < 300; ++i) {
      const IkResult& result = results[static_cast<std::size_t>(i)];
      ASSERT_EQ(result.status, IkStatus::kConverged) << i;
      EXPECT_TRUE(inside(chain, result.q));
      const Transform pose = forward_kinematics(chain, result.q.data());
      EXPECT_LE((pose.position - targets.positions.row(i).transpose()).norm(), 1.001e-6);
      EXPECT_LE(so3::distance(so3::from_matrix(pose.rotation), targets.orientations.row(i)),
                1.001e-6);
    }
  }
}

TEST(Ik, SizesOfAnotherChainAreRefused) {
  const Chain chain = test::crooked_chain();
  const JointVector q0 = middle(chain), three = JointVector::Zero(3);
  const Transform tip = forward_kinematics(chain, q0.data());
  const IkTarget target{tip.position, tip.rotation};
  IkOptions with_posture, with_reference;
  with_posture.posture = with_reference.reference = three;
  EXPECT_THROW(solve_ik(chain, target, three), std::invalid_argument);
  EXPECT_THROW(solve_ik(chain, target, q0, with_posture), std::invalid_argument);
  EXPECT_THROW(solve_ik_all(chain, target, q0, with_reference, 3, 0.1), std::invalid_argument);
  const Rows3 positions = tip.position.transpose();
  EXPECT_THROW(solve_ik_batch(chain, positions, Rows4(0, 4), Rows::Zero(2, 7), {}, 1),
               std::invalid_argument);
  EXPECT_THROW(forward_kinematics_batch(chain, Rows::Zero(2, 3)), std::invalid_argument);
}

TEST(Ik, PositionsAloneAreReachedToo) {
  const Chain chain = test::crooked_chain();
  const Poses targets = forward_kinematics_batch(chain, random_configurations(chain, 100, 3));
  const auto results = solve_ik_batch(chain, targets.positions, Rows4(0, 4),
                                      random_configurations(chain, 100, 4), {}, 1);
  for (const IkResult& result : results) EXPECT_EQ(result.status, IkStatus::kConverged);
}

TEST(Ik, ATargetBeyondTheArmIsUnreachable) {
  const Chain chain = test::crooked_chain();
  const IkTarget target{Eigen::Vector3d(10.0, 0.0, 0.0), std::nullopt};
  const IkResult result = solve_ik(chain, target, middle(chain));
  EXPECT_EQ(result.status, IkStatus::kUnreachable);
  EXPECT_TRUE(inside(chain, result.q));
  EXPECT_GT(result.position_error, 8.0);
}

TEST(Ik, ASeedOutsideTheLimitsIsMovedInside) {
  const Chain chain = test::crooked_chain();
  const Rows q = random_configurations(chain, 1, 7);
  const Transform pose = forward_kinematics(chain, q.data());
  const Eigen::VectorXd q0 = Eigen::VectorXd::Constant(chain.joints(), 100.0);
  const IkResult result = solve_ik(chain, {pose.position, pose.rotation}, q0);
  EXPECT_EQ(result.status, IkStatus::kConverged);
  EXPECT_TRUE(inside(chain, result.q));
}

TEST(Ik, TheClosestSolutionIsNeverFartherThanTheFirst) {
  const Chain chain = test::crooked_chain();
  const Poses targets = forward_kinematics_batch(chain, random_configurations(chain, 30, 8));
  const Rows starts = random_configurations(chain, 30, 9);
  IkOptions closest;
  closest.mode = IkMode::kClosest;
  const auto first = solve_ik_batch(chain, targets.positions, targets.orientations, starts, {}, 1);
  const auto nearest =
      solve_ik_batch(chain, targets.positions, targets.orientations, starts, closest, 1);
  for (std::size_t i = 0; i < first.size(); ++i) {
    const JointVector q0 = starts.row(static_cast<Eigen::Index>(i));
    ASSERT_EQ(nearest[i].status, IkStatus::kConverged);
    EXPECT_LE((nearest[i].q - q0).norm(), (first[i].q - q0).norm() + 1e-9);
  }
}

TEST(Ik, LimitsThatBarTheWayAreNamed) {
  Chain chain = test::crooked_chain();
  const Eigen::VectorXd q = middle(chain);
  JointVector lifted = middle(chain);
  lifted[0] = 0.35;
  const Transform pose = forward_kinematics(chain, lifted.data());
  for (int i = 1; i < chain.joints(); ++i) chain.lower[i] = chain.upper[i] = q[i];
  chain.upper[0] = 0.2;
  const IkResult result = solve_ik(chain, {pose.position, pose.rotation}, q);
  EXPECT_EQ(result.status, IkStatus::kLimits);
  EXPECT_TRUE(result.limiting[0]);
  EXPECT_DOUBLE_EQ(result.q[0], 0.2);
  EXPECT_NEAR(result.position_error, 0.15, 1e-9);
}

TEST(Ik, ATinyCpuBudgetEndsTheSearch) {
  const Chain chain = test::crooked_chain();
  const IkTarget target{Eigen::Vector3d(0.1, 0.1, 0.5), Eigen::Matrix3d::Identity()};
  IkOptions options;
  options.mode = IkMode::kClosest;
  options.max_iterations = options.max_restarts = 1000000000;
  options.max_cpu_seconds = 1e-3;
  const IkResult result = solve_ik(chain, target, middle(chain), options);
  EXPECT_TRUE(inside(chain, result.q));
  EXPECT_LT(result.iterations, 1000000);
}

}  // namespace leadthrough::solve_tests
