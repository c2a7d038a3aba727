#include <gtest/gtest.h>

#include <cmath>

#include "arm/robots.hpp"
#include "base/allocations.hpp"
#include "leadthrough/simulation/error_loop.hpp"
#include "leadthrough/simulation/run.hpp"

namespace leadthrough::simulation::simulation_tests {

using Eigen::Index;
using Eigen::VectorXd;

TEST(ErrorLoop, MovesAsAnOscillatorUnderASteadyForce) {
  const double period = 1e-4, frequency = 20.0;  // of a mass of 1 kg, critically damped
  const Index count = 5000;
  ErrorLoop loop({VectorXd::Zero(1), VectorXd::Zero(1), period, 1, 0, 1}, VectorXd::Zero(1));
  const Rows ease = Rows::Ones(count, 1), left = ease, still = Rows::Zero(count, 1);
  Rows answer(count, 2);
  answer.col(0).setConstant(frequency * frequency);
  answer.col(1).setConstant(2.0 * frequency);
  const Rows errors = loop.advance({ease, answer, left, still, still, still});
  for (Index k = 0; k < count; k += 100) {
    const double phase = frequency * period * static_cast<double>(k);
    const double exact = (1.0 - std::exp(-phase) * (1.0 + phase)) / (frequency * frequency);
    EXPECT_NEAR(errors(k, 0), exact, 5e-6);
  }
  EXPECT_EQ(loop.diverged(), -1);
}

// Joints without inertia but that of their motors, in a physics of one line each.
TEST(Drives, FollowCommandsExactlyWithoutDisturbances) {
  const urdf::Robot robot = std::get<urdf::Robot>(urdf::parse(test::crooked_arm()));
  const Chain chain = std::get<Chain>(make_chain(robot, "l0", "l9"));
  const Dynamics dynamics(chain);
  const Index n = chain.joints(), count = 200;
  const double period = 1e-3;
  const VectorXd none = VectorXd::Zero(n), rotors = VectorXd::Constant(n, 2.0);
  JointLaw law(dynamics, Eigen::Vector3d(0.0, 0.0, -9.81), rotors, {900.0, 60.0, none, none},
               Model::motion);
  VectorXd q = none, qd = none, control = none, force = none;
  Rows ranges = Rows::Zero(n, 2);
  std::vector<Index> joints;
  for (Index i = 0; i < n; ++i) joints.push_back(i);
  const VectorXd effort = VectorXd::Constant(n, 1e5);
  Drives drives({none, rotors, rotors, effort, none, 0, period, 1, 1e3},
                {q.data(), qd.data(), joints, control.data(), ranges.data(), force.data()},
                Rows::Zero(3, n));
  const Rows qdd = Rows::Constant(count, n, 0.5);
  Rows planned(count, n), speeds(count, n);
  for (Index k = 0; k < count; ++k) {
    speeds.row(k).setConstant(0.5 * period * static_cast<double>(k));
    planned.row(k).setConstant(k == 0 ? 0.0 : planned(k - 1, 0) + period * speeds(k, 0));
  }
  // The dynamics are solved for the acceleration by the mass matrix of the same arm.
  const auto step = [&] {
    const Rows mass = dynamics.mass_matrices(q.transpose());
    Rows whole = Eigen::Map<const Rows>(mass.data(), n, n);
    whole.diagonal() += rotors;
    const Rows bias = dynamics.torques(q.transpose(), qd.transpose(), none.transpose(),
                                       Eigen::Vector3d(0.0, 0.0, -9.81));
    force = control;
    qd += period * whole.ldlt().solve(control - bias.row(0).transpose());
    q += period * qd;
    return false;
  };
  const VectorXd progress = VectorXd::Zero(count);
  const Eigen::Ref<const Rows> a(planned), b(speeds), c(qdd);
  const Eigen::Ref<const VectorXd> d(progress);
  const auto asked = [&](const Moment& now, VectorXd& torques) { torques = law.torques(now); };
  const Record record = run(drives, {a, b, c, d}, asked, {step, [](Index) {}, 0});
  EXPECT_EQ(record.periods, count);
  EXPECT_LE((record.q - planned).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT(record.use.maxCoeff(), 1.0);

  const Rows command = Rows::Zero(3, n);
  const Drives::Law ready = asked;
  const std::size_t before = test::allocations();
  for (int k = 0; k < 10; ++k) {
    drives.begin(command, 0.0, ready);
    drives.act(0);
    drives.advance();
    drives.end();
  }
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace leadthrough::simulation::simulation_tests
