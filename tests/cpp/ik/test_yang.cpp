#include <gtest/gtest.h>

#include <random>

#include "arm/robots.hpp"
#include "base/dense.hpp"
#include "leadthrough/arm/jacobian.hpp"
#include "leadthrough/ik/yang.hpp"
#include "leadthrough/rotation/so3.hpp"

namespace leadthrough::yang_tests {

namespace {

Eigen::VectorXd random_configuration(std::mt19937& generator, const Chain& chain) {
  std::uniform_real_distribution<double> uniform(0.1, 0.9);
  Eigen::VectorXd q(chain.joints());
  for (int i = 0; i < chain.joints(); ++i) {
    const double lower = std::max(chain.lower[i], -2.0), upper = std::min(chain.upper[i], 2.0);
    q[i] = lower + uniform(generator) * (upper - lower);
  }
  return q;
}

Eigen::MatrixXd jacobian_at(const Chain& chain, const Eigen::VectorXd& q) {
  const Rows flat = jacobian_batch(chain, Rows(q.transpose()));
  return Eigen::Map<const Rows>(flat.data(), 6, chain.joints());
}

const Vector6 kTwist = (Vector6() << 0.1, -0.2, 0.05, 0.3, 0.1, -0.4).finished();

}  // namespace

TEST(Yang, AStepIsThePapersEquations) {
  const Chain chain = test::crooked_chain();
  std::mt19937 generator(1);
  YangOptions options;
  options.alpha = 1e-3;
  options.condition_threshold = 3.0;
  for (int repeat = 0; repeat < 50; ++repeat) {
    const Eigen::VectorXd q = random_configuration(generator, chain);
    const YangStep step = yang_step(chain, q.data(), kTwist, false, options);
    Vector6 weight = Vector6::Ones();
    weight.tail<3>().setConstant(options.rotation_weight);
    const Eigen::MatrixXd J = weight.asDiagonal() * jacobian_at(chain, q);
    const Eigen::VectorXd sigma = test::singular_values(J);
    const double kappa = sigma[0] / sigma[5];
    EXPECT_NEAR(step.condition, kappa, 1e-9 * kappa);
    const double lambda2 =
        std::pow(options.damping, 2) * std::max(1.0 - std::pow(3.0 / kappa, 2), 0.0);
    EXPECT_NEAR(step.damping * step.damping, lambda2, 1e-12);
    const Eigen::MatrixXd regular =
        J * J.transpose() + (lambda2 + options.alpha) * Eigen::MatrixXd::Identity(6, 6);
    const Eigen::MatrixXd inverse = test::pseudo_inverse(J);
    Eigen::VectorXd to_middle = options.nullspace_gain * (middle(chain) - q);
    for (int i = 0; i < chain.joints(); ++i)
      if (!std::isfinite(chain.lower[i])) to_middle[i] = 0.0;
    const Eigen::VectorXd expected =
        J.transpose() * test::pseudo_inverse(regular) * weight.cwiseProduct(kTwist) +
        (Eigen::MatrixXd::Identity(7, 7) - inverse * J) * to_middle;
    EXPECT_LE((step.velocity - expected).norm(), 1e-9 * expected.norm());
  }
}

TEST(Yang, TheSecondaryTaskLeavesTheToolAlone) {
  const Chain chain = test::crooked_chain();
  std::mt19937 generator(2);
  YangOptions options;
  options.condition_threshold = 1.0;  // damped everywhere
  options.nullspace_gain = 5.0;
  for (int repeat = 0; repeat < 50; ++repeat) {
    const Eigen::VectorXd q = random_configuration(generator, chain);
    const YangStep step = yang_step(chain, q.data(), Vector6::Zero(), false, options);
    EXPECT_GT(step.velocity.norm(), 1e-3);
    EXPECT_LE((jacobian_at(chain, q) * step.velocity).norm(), 1e-9);
  }
}

TEST(Yang, ASingularConfigurationGivesAFiniteStep) {
  const auto robot = std::get<urdf::Robot>(urdf::parse(test::crooked_arm()));
  const Chain chain = std::get<Chain>(make_chain(robot, "l0", "l4"));  // fewer joints than axes
  const Eigen::VectorXd q = Eigen::VectorXd::Zero(chain.joints());
  for (const double damping : {0.0, 0.1}) {
    YangOptions options;
    options.damping = damping;
    EXPECT_TRUE(yang_step(chain, q.data(), kTwist, false, options).velocity.allFinite());
    EXPECT_TRUE(yang_step(chain, q.data(), kTwist, true, options).velocity.allFinite());
  }
}

TEST(Yang, APathIsFollowedOneStepASample) {
  const Chain chain = test::crooked_chain();
  std::mt19937 generator(3);
  const Eigen::VectorXd start = random_configuration(generator, chain);
  const Transform pose = forward_kinematics(chain, start.data());
  constexpr int kSamples = 200;
  Rows3 positions(kSamples, 3);
  Rows4 orientations(kSamples, 4);
  for (int k = 0; k < kSamples; ++k) {
    positions.row(k) = pose.position.transpose() + Eigen::RowVector3d(0.0, 0.0, 2e-4 * k);
    orientations.row(k) = so3::from_matrix(pose.rotation);
  }
  YangOptions options;
  options.damping = 0.0;
  const YangPath path = yang_path(chain, positions, orientations, start,
                                  Eigen::VectorXd::Constant(kSamples, 0.01), options);
  EXPECT_LE(path.position_errors.maxCoeff(), 1e-4);
  EXPECT_TRUE((path.damping.array() == 0.0).all());
  EXPECT_TRUE((path.condition.array() >= 1.0).all());
}

}  // namespace leadthrough::yang_tests
