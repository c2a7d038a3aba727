#include <gtest/gtest.h>

#include <cmath>

#include "arm/robots.hpp"
#include "leadthrough/ik/tracking.hpp"

namespace leadthrough::tracking_tests {

namespace {

// Poses of a smooth motion of the joints.
Rows smooth_motion(const Chain& chain, int samples) {
  Rows q(samples, chain.joints());
  for (int k = 0; k < samples; ++k)
    for (int i = 0; i < chain.joints(); ++i)
      q(k, i) = 0.17 + 0.15 * std::sin(0.5 * i + 3.0 * k / samples);
  return q;
}

Rows to_middle(const Chain& chain, Eigen::Index samples) {
  return middle(chain).transpose().replicate(samples, 1);
}

Rows steps_of(const Rows& q) { return q.bottomRows(q.rows() - 1) - q.topRows(q.rows() - 1); }

}  // namespace

TEST(Tracking, FollowsASmoothPathWithoutAJump) {
  const Chain chain = test::crooked_chain();
  const Rows q = smooth_motion(chain, 400);
  const Poses path = forward_kinematics_batch(chain, q);
  const Eigen::VectorXd start = q.row(0);
  for (const double rate : {0.0, 0.01}) {
    const Track track =
        leadthrough::track(chain, path.positions, path.orientations, start,
                           {to_middle(chain, q.rows()), Eigen::VectorXd::Constant(q.rows(), rate)});
    ASSERT_EQ(track.q.rows(), q.rows());
    EXPECT_LE(track.position_errors.maxCoeff(), 1e-6);
    EXPECT_LE(track.orientation_errors.maxCoeff(), 1e-6);
    EXPECT_LE(steps_of(track.q).cwiseAbs().maxCoeff(), 0.05);
  }
}

// The crooked arm has a joint to spare: it stands as it was shown to, and not as it did at first.
TEST(Tracking, ARedundantArmComesToThePostureThatItIsShown) {
  const Chain chain = test::crooked_chain();
  ASSERT_GT(chain.joints(), 6);
  const Rows q = smooth_motion(chain, 400);
  const Poses path = forward_kinematics_batch(chain, q);
  const auto pulled = [&](double share) {
    return track(chain, path.positions, path.orientations, middle(chain),
                 {q, Eigen::VectorXd::Constant(q.rows(), share)});
  };
  const auto distance = [&](const Track& track) { return (track.q - q).row(399).norm(); };
  const Track near = pulled(0.1);
  const Track free = pulled(0.0);
  ASSERT_EQ(near.q.rows(), q.rows());
  EXPECT_LE(near.position_errors.maxCoeff(), 1e-5);
  EXPECT_LE(distance(near), 1e-2);
  EXPECT_GT(distance(free), 10.0 * distance(near));
}

TEST(Tracking, EndsWithTheSampleThatItsStepsDoNotReach) {
  const Chain chain = test::crooked_chain();
  const Rows q = smooth_motion(chain, 40);
  const Poses path = forward_kinematics_batch(chain, q);
  TrackOptions options;
  options.max_step = 5e-3;
  const Track track = leadthrough::track(
      chain, path.positions, path.orientations, Eigen::VectorXd(q.row(0)),
      {to_middle(chain, q.rows()), Eigen::VectorXd::Constant(q.rows(), 0.1)}, options);
  ASSERT_LT(track.q.rows(), q.rows());
  ASSERT_GT(track.q.rows(), 1);
  EXPECT_LE(steps_of(track.q).cwiseAbs().maxCoeff(), options.max_step * (1.0 + 1e-12));
  const Eigen::Index last = track.q.rows() - 1;
  EXPECT_GT(track.position_errors[last] + track.orientation_errors[last], 1e-5);
}

TEST(Tracking, PursuitOfPointsAloneKeepsThePath) {
  const Chain chain = test::crooked_chain();
  const Rows q = smooth_motion(chain, 200);
  const Poses path = forward_kinematics_batch(chain, q);
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(200, 0.0, 4.0);
  const Eigen::VectorXd limit = Eigen::VectorXd::Constant(chain.joints(), 1.5);
  const Track track =
      pursue(chain, {times, path.positions, Rows4(0, 4)}, Eigen::VectorXd(q.row(0)),
             {q, Eigen::VectorXd::Zero(200)}, {limit, 10.0 * limit, 0.0, {100.0, 100.0}});
  ASSERT_EQ(track.q.rows(), 200);
  const Poses made = forward_kinematics_batch(chain, track.q);
  EXPECT_LE((made.positions - path.positions).rowwise().norm().maxCoeff(), 1e-4);
}

// A jump of the path is caught up with, braking alike whichever way the joints turn.
TEST(Tracking, PursuitOfAMirroredPathIsMirrored) {
  const std::string limit =
      "<axis xyz='0 0 1'/><limit lower='-3' upper='3' velocity='2' effort='1'/>";
  const std::string ahead = "<origin xyz='0.5 0 0'/>";
  const auto robot = std::get<urdf::Robot>(
      urdf::parse("<robot name='planar'>" + test::link("l0") + test::link("l1") + test::link("l2") +
                  test::link("tip") + test::joint("j1", "revolute", "l0", "l1", limit) +
                  test::joint("j2", "revolute", "l1", "l2", ahead + limit) +
                  test::joint("end", "fixed", "l2", "tip", ahead) + "</robot>"));
  const Chain chain = std::get<Chain>(make_chain(robot, "l0", "tip"));
  constexpr int kCount = 120;
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(kCount, 0.0, 1.19);
  const Eigen::VectorXd limits = Eigen::VectorXd::Constant(2, 2.0);
  Rows tracks[2];
  for (const int mirrored : {0, 1}) {
    const double side = mirrored ? -1.0 : 1.0;
    Rows way(kCount, 2);
    for (int k = 0; k < kCount; ++k) way.row(k) << side * (k < 20 ? 0.2 : 0.5), side * 0.7;
    const Poses path = forward_kinematics_batch(chain, way);
    const Pull none{Rows::Zero(kCount, 2), Eigen::VectorXd::Zero(kCount)};
    const Track track =
        pursue(chain, {times, path.positions, Rows4(0, 4)}, Eigen::VectorXd(way.row(0)), none,
               {limits, 4.0 * limits, 0.0, {100.0, 100.0}});
    ASSERT_EQ(track.q.rows(), kCount);
    EXPECT_LE(side * track.q(kCount - 1, 0) - 0.5, 1e-4);
    EXPECT_LE((side * track.q.col(0)).maxCoeff(), 0.5 + 5e-3);  // no overshoot
    tracks[mirrored] = track.q;
  }
  EXPECT_LT((tracks[0] + tracks[1]).cwiseAbs().maxCoeff(), 1e-9);
}

// At a constant tip pose, self-motion takes three tenths of the joints' speed, in both directions.
TEST(Tracking, AFarPostureIsApproachedGently) {
  const Chain chain = test::crooked_chain();
  const int samples = 12;
  const Eigen::VectorXd limit = Eigen::VectorXd::Constant(chain.joints(), 1.5);
  const Poses still =
      forward_kinematics_batch(chain, Rows(middle(chain).transpose().replicate(samples, 1)));
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(samples, 0.0, 0.01 * (samples - 1));
  for (const double side : {-1.0, 1.0}) {
    const Rows far = to_middle(chain, samples).array() + side;
    const Track track =
        pursue(chain, {times, still.positions, still.orientations}, middle(chain),
               {far, Eigen::VectorXd::Ones(samples)}, {limit, 1e4 * limit, 0.0, {100.0, 100.0}});
    ASSERT_EQ(track.q.rows(), samples);
    const double fastest = steps_of(track.q).rowwise().norm().maxCoeff() / 0.01;
    EXPECT_LE(fastest, 0.3 * limit.norm());
    EXPECT_GT(fastest, 0.02 * limit.norm());
  }
}

// However wild the path, the joints keep their limits, and the arm comes to rest in time.
TEST(Tracking, PursuitNeverLeavesTheLimits) {
  const Chain chain = test::crooked_chain();
  const int samples = 300;
  Rows wild(samples, chain.joints());
  Eigen::VectorXd times(samples);
  for (int k = 0; k < samples; ++k) {
    times[k] = 0.01 * k + 0.004 * std::sin(0.9 * k);  // uneven
    for (int i = 0; i < chain.joints(); ++i)
      wild(k, i) = 3.0 * std::sin(0.02 * (i + 1) * k) * (k % 50 < 3 ? -1.0 : 1.0);
  }
  const Poses path = forward_kinematics_batch(chain, wild);
  const Eigen::VectorXd limit = Eigen::VectorXd::Constant(chain.joints(), 1.5);
  PursuitOptions options{limit, 4.0 * limit, 0.0, {100.0, 100.0}};
  const Track track =
      pursue(chain, {times, path.positions, path.orientations}, middle(chain),
             {to_middle(chain, samples), Eigen::VectorXd::Constant(samples, 0.01)}, options);
  ASSERT_EQ(track.q.rows(), samples);
  Eigen::VectorXd last = Eigen::VectorXd::Zero(chain.joints());
  double before = times[1] - times[0];
  for (Eigen::Index k = 0; k < samples; ++k) {
    EXPECT_TRUE((track.q.row(k).transpose().array() >= chain.lower.array()).all());
    EXPECT_TRUE((track.q.row(k).transpose().array() <= chain.upper.array()).all());
    const bool ended = k + 1 == samples;
    const double duration = ended ? before : times[k + 1] - times[k];
    Eigen::VectorXd velocity = Eigen::VectorXd::Zero(chain.joints());
    if (!ended) velocity = (track.q.row(k + 1) - track.q.row(k)).transpose() / duration;
    EXPECT_LE(velocity.cwiseAbs().maxCoeff(), 1.5 * (1.0 + 1e-9));
    const Eigen::VectorXd acceleration = (velocity - last) / (0.5 * (before + duration));
    EXPECT_LE(acceleration.cwiseAbs().maxCoeff(), 6.0 * (1.0 + 1e-9)) << "at sample " << k;
    last = velocity;
    before = duration;
  }
}

}  // namespace leadthrough::tracking_tests
