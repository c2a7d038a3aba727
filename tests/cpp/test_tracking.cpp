#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "leadthrough/tracking.hpp"
#include "robots.hpp"

using namespace leadthrough;

namespace {

constexpr double kNoBound = std::numeric_limits<double>::infinity();

Chain crooked_chain() {
  const auto robot = std::get<urdf::Robot>(urdf::parse(test::crooked_arm()));
  return std::get<Chain>(make_chain(robot, "l0", "l9"));
}

// Poses of a smooth motion of the joints.
Rows smooth_motion(const Chain& chain, int samples) {
  Rows q(samples, chain.joints());
  for (int k = 0; k < samples; ++k)
    for (int i = 0; i < chain.joints(); ++i)
      q(k, i) = 0.17 + 0.15 * std::sin(0.5 * i + 3.0 * k / samples);
  return q;
}

}  // namespace

TEST(Tracking, FollowsASmoothPathWithoutAJump) {
  const Chain chain = crooked_chain();
  const Rows q = smooth_motion(chain, 400);
  const Poses path = forward_kinematics_batch(chain, q);
  const Eigen::VectorXd start = q.row(0);
  for (const double midrange : {0.0, 0.01}) {
    const Track track = leadthrough::track(chain, path.positions, path.orientations, start,
                                           Rows::Constant(q.rows(), q.cols(), kNoBound),
                                           Eigen::VectorXd::Constant(q.rows(), midrange));
    EXPECT_EQ(track.reached(), q.rows());
    EXPECT_LE(track.position_errors.maxCoeff(), 1e-6);
    EXPECT_LE(track.orientation_errors.maxCoeff(), 1e-6);
    const Rows steps = track.q.bottomRows(q.rows() - 1) - track.q.topRows(q.rows() - 1);
    EXPECT_LE(steps.cwiseAbs().maxCoeff(), 0.05);
  }
}

TEST(Tracking, StepsNeverExceedTheirBoundsNorTheLimits) {
  const Chain chain = crooked_chain();
  const Rows q = smooth_motion(chain, 40);
  const Poses path = forward_kinematics_batch(chain, q);
  const double bound = 5e-3;
  const Track track = leadthrough::track(chain, path.positions, path.orientations, middle(chain),
                                         Rows::Constant(q.rows(), q.cols(), bound),
                                         Eigen::VectorXd::Constant(q.rows(), 0.1));
  EXPECT_LT(track.reached(), q.rows());
  const Rows steps = track.q.bottomRows(q.rows() - 1) - track.q.topRows(q.rows() - 1);
  EXPECT_LE(steps.cwiseAbs().maxCoeff(), bound * (1.0 + 1e-12));
  for (Eigen::Index k = 0; k < q.rows(); ++k) {
    EXPECT_TRUE((track.q.row(k).transpose().array() >= chain.lower.array()).all());
    EXPECT_TRUE((track.q.row(k).transpose().array() <= chain.upper.array()).all());
  }
}
