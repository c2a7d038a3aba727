#include <gtest/gtest.h>

#include <stdexcept>

#include "arm/robots.hpp"
#include "leadthrough/arm/jacobian.hpp"
#include "leadthrough/collision/clearance.hpp"
#include "leadthrough/collision/edges.hpp"
#include "leadthrough/dmp/avoidance.hpp"
#include "leadthrough/dmp/orientation_curve.hpp"
#include "leadthrough/guard/brake.hpp"
#include "leadthrough/guard/bridge.hpp"
#include "leadthrough/guard/contact.hpp"
#include "leadthrough/guard/pace.hpp"
#include "leadthrough/ik/yang.hpp"
#include "leadthrough/learn/alignment.hpp"
#include "leadthrough/learn/basis_functions.hpp"
#include "leadthrough/learn/gaussian.hpp"
#include "leadthrough/learn/sample_truncated_gaussian.hpp"
#include "leadthrough/path/clear_path.hpp"
#include "leadthrough/rotation/curve.hpp"
#include "leadthrough/rotation/mean.hpp"
#include "leadthrough/time/cubic_spline.hpp"
#include "leadthrough/time/curve_values.hpp"
#include "leadthrough/time/jerk_filter.hpp"
#include "leadthrough/time/line_law.hpp"
#include "leadthrough/time/quintic_step.hpp"
#include "leadthrough/time/slowing.hpp"
#include "leadthrough/time/spline_fit.hpp"
#include "leadthrough/time/time_law.hpp"

// Functions that take arrays refuse sizes that disagree, instead of reading beyond them.
namespace leadthrough::arguments_tests {

namespace {

const Eigen::VectorXd kTwo = Eigen::VectorXd::LinSpaced(2, 0.0, 1.0);
const Eigen::VectorXd kThree = Eigen::VectorXd::LinSpaced(3, 0.0, 2.0);
const Eigen::VectorXd kEight = Eigen::VectorXd::LinSpaced(8, 0.0, 7.0);

Rows rows(Eigen::Index count, Eigen::Index columns) { return Rows::Ones(count, columns); }

template <typename Call>
bool refuses(const Call& call) {
  try {
    call();
  } catch (const std::invalid_argument&) {
    return true;
  }
  return false;
}

}  // namespace

TEST(Arguments, OfRotationsHaveAsManyRows) {
  const so3::Quaternions two = rows(2, 4), three = rows(3, 4);
  EXPECT_TRUE(refuses([&] { so3::compose_batch(two, three); }));
  EXPECT_TRUE(refuses([&] { so3::distance_batch(two, three); }));
  EXPECT_TRUE(refuses([&] { so3::slerp_batch(two, two, kThree); }));
  EXPECT_TRUE(refuses([&] { so3::slerp_through(kTwo, three, kTwo); }));
  EXPECT_TRUE(refuses(
      [&] { so3::integrate(kTwo, so3::Vectors::Ones(3, 3), so3::Quaternion(1, 0, 0, 0)); }));
  EXPECT_TRUE(refuses([&] { so3::mean_batch(three, kTwo); }));
}

TEST(Arguments, OfMotionsHaveOneRowATimeAndOneColumnAJoint) {
  EXPECT_TRUE(refuses([&] { fit_spline(kEight, rows(7, 2), 1e-3, true); }));
  EXPECT_TRUE(refuses([&] { fit_spline(kThree, rows(3, 2), 1e-3, true); }));
  EXPECT_TRUE(refuses([&] { smooth_spline(kEight, rows(8, 2), 1e-3, {kTwo, kThree}); }));
  EXPECT_TRUE(refuses([&] { rows_apart(rows(0, 2), 1e-3); }));
  EXPECT_TRUE(refuses([&] { cubic_through(kEight, rows(7, 2)); }));
  EXPECT_TRUE(refuses([&] { spline_slopes(kEight, rows(7, 2), SplineEnds::kAtRest); }));
  EXPECT_TRUE(refuses([&] { polynomial_values(kThree, rows(5, 2), kTwo, 0); }));
  EXPECT_TRUE(refuses([&] { bezier_values(rows(0, 2), kTwo); }));
  EXPECT_TRUE(refuses([&] { time_lines(rows(3, 2), {kTwo, kThree, kTwo}, 1e-3, 1e6); }));
  EXPECT_TRUE(refuses([&] { step_extremes(kThree, rows(3, 2), rows(2, 2), rows(3, 2)); }));
  EXPECT_TRUE(refuses([&] { motion_peaks(kThree, rows(3, 2), rows(3, 2), rows(3, 1)); }));
  EXPECT_TRUE(refuses([&] { slow_down(kThree, rows(2, 2), kTwo, kTwo); }));
  EXPECT_TRUE(refuses([&] { times_to_rest(rows(3, 2), rows(6, 2), kThree); }));
  EXPECT_TRUE(refuses([&] { step_together(rows(3, 2), rows(5, 2), kTwo, 1e-3); }));
}

TEST(Arguments, OfTimeLawsFitThePath) {
  PolynomialPath path{kTwo, Rows::Zero(2, 2)};
  path.coefficients.row(1) << 1.0, -1.0;
  EXPECT_TRUE(refuses([&] { make_path_grid(path, kThree, 10); }));
  EXPECT_TRUE(refuses([&] { make_path_grid(path, kTwo, 2); }));
  EXPECT_TRUE(refuses([&] { make_path_grid({kTwo, Rows()}, kTwo, 10); }));
  const PathGrid grid = make_path_grid(path, Eigen::Vector2d::Ones(), 10);
  const Rows none(grid.points(), 0);
  const Eigen::VectorXd fastest = Eigen::VectorXd::Constant(grid.points(), 1.0);
  const Eigen::VectorXd limit = Eigen::Vector2d::Ones();
  EXPECT_NO_THROW(
      make_time_law(path, grid, {limit, limit, limit}, {fastest, none, none, none, none}));
  EXPECT_TRUE(refuses([&] {
    make_time_law(path, grid, {limit, kThree, limit}, {fastest, none, none, none, none});
  }));
  EXPECT_TRUE(refuses(
      [&] { make_time_law(path, grid, {limit, limit, limit}, {kTwo, none, none, none, none}); }));
  EXPECT_TRUE(refuses([&] { states_along(path, grid, kThree, kThree, kTwo); }));
}

TEST(Arguments, OfTheGuardAreStatesOfAllJoints) {
  const Eigen::VectorXd ones = Eigen::Vector2d::Ones();
  const guard::StepLimits limits{-ones, ones, ones, ones, ones, 1e-2};
  const Rows start = Rows::Zero(1, 6), path = Rows::Zero(4, 6);
  EXPECT_NO_THROW(guard::check_limits(limits));
  EXPECT_NO_THROW(guard::brake(limits, start));
  EXPECT_TRUE(refuses([&] { guard::check_limits({-ones, ones, ones, ones, kThree, 1e-2}); }));
  EXPECT_TRUE(refuses([&] { guard::check_limits({-ones, ones, ones, 0.0 * ones, ones, 1e-2}); }));
  EXPECT_TRUE(refuses([&] { guard::first_excess(limits, start, rows(4, 5)); }));
  EXPECT_TRUE(refuses([&] { guard::brake(limits, rows(1, 5)); }));
  EXPECT_TRUE(refuses([&] { guard::bridge_to_start(limits, start, rows(4, 5), 10); }));
  EXPECT_TRUE(refuses([&] { guard::bridge_on_time(limits, start, path, guard::kMaxBridge + 1); }));
  EXPECT_TRUE(refuses([&] { guard::joined(limits, start, path, -limits.jerk, 1.0); }));
  EXPECT_TRUE(refuses([&] { guard::slowed(limits, rows(4, 5), 10); }));
  EXPECT_TRUE(refuses([&] { guard::stopped(limits, rows(2, 6), path); }));
  EXPECT_TRUE(refuses([&] { guard::eased(limits, start, path, 0.0); }));
}

TEST(Arguments, OfAnArmFitItsChain) {
  const Chain chain = test::crooked_chain();
  CollisionModel model;
  model.chain = chain;
  const auto scene = guard::guarded_scene(model, {}, {}, 0.0, 0.0);
  const Eigen::VectorXd seven = Eigen::VectorXd::Zero(7);
  EXPECT_TRUE(refuses([&] { clear_batch(scene.arm, rows(2, 6)); }));
  EXPECT_TRUE(refuses([&] { check_motion(scene.arm.scene, rows(2, 6)); }));
  EXPECT_TRUE(refuses([&] { check_motion(scene.arm.scene, rows(0, 7)); }));
  EXPECT_TRUE(refuses([&] { guard::first_contact(scene, seven, rows(2, 6), 0.0); }));
  EXPECT_TRUE(refuses([&] { guard::guarded_scene(model, {}, {0.1}, 0.0, 0.0); }));
  EXPECT_TRUE(
      refuses([&] { solve_yang_batch(chain, rows(2, 3), rows(1, 4), rows(2, 7), {}, 10, {}, 1); }));
  EXPECT_TRUE(
      refuses([&] { solve_yang_batch(chain, rows(2, 3), rows(2, 4), rows(2, 6), {}, 10, {}, 1); }));
  EXPECT_TRUE(refuses([&] { yang_path(chain, rows(2, 3), rows(2, 4), seven, kThree, {}); }));
  EXPECT_TRUE(refuses([&] { jacobian_derivative_batch(chain, rows(2, 7), rows(1, 7)); }));
  const Rows none(0, 6);
  EXPECT_TRUE(refuses([&] {
    path::find_clear_path(model, {}, {rows(2, 3), rows(1, 4), {}, none}, rows(2, 7), {}, {}, {});
  }));
  EXPECT_TRUE(refuses([&] {
    path::find_clear_path(model, {}, {rows(2, 3), rows(2, 4), {}, none}, rows(2, 6), {}, {}, {});
  }));
}

TEST(Arguments, OfDistributionsFitTheBasis) {
  const Columns first = Columns::Zero(1);
  const auto condition = [&](const Rows& covariance, const Columns& columns, const Rows& values) {
    return condition_weights(kTwo, covariance, rows(1, 2), columns, values, rows(1, 1),
                             Eigen::VectorXd::Ones(1), 1e-9);
  };
  EXPECT_NO_THROW(condition(Rows::Identity(2, 2), first, rows(1, 1)));
  EXPECT_TRUE(refuses([&] { condition(Rows::Identity(3, 3), first, rows(1, 1)); }));
  EXPECT_TRUE(refuses([&] { condition(Rows::Identity(2, 2), Columns::Ones(1), rows(1, 1)); }));
  EXPECT_TRUE(refuses([&] { condition(Rows::Identity(2, 2), first, rows(2, 1)); }));
  EXPECT_TRUE(refuses([&] { is_covariance(rows(2, 3)); }));
  EXPECT_TRUE(refuses([&] { dtw_distance(rows(2, 3), rows(4, 2)); }));
  EXPECT_TRUE(refuses([&] { dtw_path(rows(2, 3), rows(0, 3)); }));
  EXPECT_TRUE(refuses([&] { frechet_distance(rows(2, 3), rows(4, 3), 0); }));
  EXPECT_TRUE(refuses([&] { normalised_basis(kTwo, kTwo, 1.0, false, 3); }));
  EXPECT_TRUE(refuses([&] { sample_truncated_gaussian(rows(2, 2), kThree, kTwo, rows(4, 2)); }));
}

TEST(Arguments, OfPrimitivesHaveTheirChannels) {
  using namespace dmp;
  const Path path = minimum_jerk(Vector::Zero(2), Vector::Ones(2));
  const Forces forces{Rows::Zero(2, 2), Vector::Zero(2), 4.0, Canonical::kDiscrete};
  const Course course{path, Vector::Ones(2), Vector::Zero(2)};
  const State state{Vector::Zero(2), Vector::Zero(2), 0.0};
  EXPECT_NO_THROW(rollout(forces, course, state, kTwo));
  EXPECT_TRUE(
      refuses([&] { rollout(forces, course, {Vector::Zero(3), Vector::Zero(3), 0.0}, kTwo); }));
  EXPECT_TRUE(refuses([&] { rollout(forces, course, state, Vector()); }));
  EXPECT_TRUE(refuses([&] { rollout(forces, course, state, -kTwo); }));
  const AvoidanceScene scene{{}, 0.1, kThree, kThree};
  EXPECT_TRUE(refuses([&] { rollout_around(forces, course, scene, state, kTwo); }));
  EXPECT_TRUE(refuses([&] { shifted(path, rows(6, 3), Vector::Zero(2), Vector::Zero(2)); }));
  EXPECT_TRUE(refuses([&] { superposed(path, {0.0, 1.0, kTwo, kTwo, kThree}); }));
  EXPECT_TRUE(refuses([&] { orientations_at({}, {}, kTwo, rows(3, 3)); }));
}

}  // namespace leadthrough::arguments_tests
