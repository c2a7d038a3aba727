#include <gtest/gtest.h>

#include "arm/robots.hpp"
#include "base/allocations.hpp"
#include "leadthrough/ik/tracking.hpp"
#include "leadthrough/ik/yang.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace leadthrough::no_allocation_tests {

namespace {

template <typename Work>
std::size_t count(const Work& work) {
  const std::size_t before = test::allocations();
  work();
  return test::allocations() - before;
}

IkTarget target_of(const Chain& chain, const Eigen::VectorXd& q) {
  const Transform pose = forward_kinematics(chain, q.data());
  return {pose.position, pose.rotation};
}

struct Path {
  Rows3 positions;
  Rows4 orientations;
  Rows starts;
};

Path still(const Chain& chain, int samples) {
  const Eigen::VectorXd q = middle(chain);
  const Transform pose = forward_kinematics(chain, q.data());
  return {pose.position.transpose().replicate(samples, 1),
          so3::from_matrix(pose.rotation).transpose().replicate(samples, 1),
          Rows::Constant(samples, chain.joints(), 0.3)};
}

}  // namespace

TEST(NoAllocation, ASinglePoseIsSolvedWithout) {
  const Chain chain = test::crooked_chain();
  const Eigen::VectorXd q0 = middle(chain);
  const IkTarget reached = target_of(chain, Eigen::VectorXd::Constant(chain.joints(), 0.3));
  const IkTarget beyond{Eigen::Vector3d(1.5, 0.2, 0.3), reached.rotation};
  IkAxes spinning;
  spinning.free[5] = true;
  for (const IkTarget& target : {reached, beyond}) {
    for (const IkMode mode : {IkMode::kFastest, IkMode::kClosest}) {
      for (const bool by_axes : {false, true}) {
        for (const double nullspace_gain : {0.0, 1.0}) {
          IkOptions options;
          options.mode = mode;
          options.nullspace_gain = nullspace_gain;
          if (by_axes) options.axes = spinning;
          if (nullspace_gain > 0.0) options.posture = middle(chain);
          IkResult result;
          EXPECT_EQ(count([&] { result = solve_ik(chain, target, q0, options); }), 0U);
        }
      }
    }
  }
  const IkTarget point{reached.position, std::nullopt};
  EXPECT_EQ(count([&] { solve_ik(chain, point, q0); }), 0U);
}

TEST(NoAllocation, AllPosturesCostNoMoreThanTheirList) {
  const Chain chain = test::crooked_chain();
  const Eigen::VectorXd q0 = middle(chain);
  const IkTarget target = target_of(chain, Eigen::VectorXd::Constant(chain.joints(), 0.3));
  EXPECT_LE(count([&] { solve_ik_all(chain, target, q0, {}, 64, 0.1); }), 1U);
}

TEST(NoAllocation, BatchesAndPathsDoNotAllocateInTheirLoops) {
  const Chain chain = test::crooked_chain();
  const auto batch = [&](int samples) {
    const Path path = still(chain, samples);
    return count(
        [&] { solve_ik_batch(chain, path.positions, path.orientations, path.starts, {}, 1); });
  };
  EXPECT_EQ(batch(10), batch(100));
  const auto along = [&](int samples) {
    const Path path = still(chain, samples);
    const Eigen::VectorXd rates = Eigen::VectorXd::Constant(samples, 0.01);
    const Eigen::VectorXd start = middle(chain);
    const Rows postures = start.transpose().replicate(samples, 1);
    return count(
        [&] { track(chain, path.positions, path.orientations, start, {postures, rates}); });
  };
  EXPECT_EQ(along(10), along(100));
}

TEST(NoAllocation, AStepOfThePlainMethodIsWithout) {
  const Chain chain = test::crooked_chain();
  const JointVector q = middle(chain);
  const Vector6 twist = Vector6::Ones();
  EXPECT_EQ(count([&] { yang_step(chain, q.data(), twist, false); }), 0U);
}

}  // namespace leadthrough::no_allocation_tests
