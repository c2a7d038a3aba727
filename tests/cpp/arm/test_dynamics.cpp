#include <gtest/gtest.h>

#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#include <random>

#include "arm/kdl_chain.hpp"
#include "arm/robots.hpp"
#include "leadthrough/arm/dynamics.hpp"

namespace leadthrough::dynamics_tests {

namespace {

Rows random_rows(Eigen::Index rows, Eigen::Index cols, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-2.0, 2.0);
  return Rows::NullaryExpr(rows, cols, [&] { return uniform(generator); });
}

const Eigen::Vector3d kGravity(1.0, -2.0, -9.81);

}  // namespace

TEST(Dynamics, LinksFixedToEachOtherActAsOneBody) {
  const urdf::Robot robot = std::get<urdf::Robot>(urdf::parse(test::crooked_arm()));
  const Chain chain = std::get<Chain>(make_chain(robot, "l0", "l9"));
  EXPECT_DOUBLE_EQ(chain.mass, 9 * 1.5);
  const KDL::Chain peer = test::kdl_chain(robot, "l0", "l9");  // a segment for every link
  KDL::ChainIdSolver_RNE solver(peer, KDL::Vector(kGravity[0], kGravity[1], kGravity[2]));
  const KDL::Wrenches none(peer.getNrOfSegments(), KDL::Wrench::Zero());
  const Rows q = random_rows(50, chain.joints(), 1);
  const Rows qd = random_rows(50, chain.joints(), 2);
  const Rows qdd = random_rows(50, chain.joints(), 3);
  const Rows torques = Dynamics(chain).torques(q, qd, qdd, kGravity);
  for (Eigen::Index row = 0; row < q.rows(); ++row) {
    KDL::JntArray values(peer.getNrOfJoints()), rates = values, second = values, expected = values;
    values.data = q.row(row);
    rates.data = qd.row(row);
    second.data = qdd.row(row);
    ASSERT_EQ(solver.CartToJnt(values, rates, second, none, expected), 0);
    EXPECT_LE((torques.row(row).transpose() - expected.data).cwiseAbs().maxCoeff(), 1e-11);
  }
}

TEST(Dynamics, TheMassMatrixIsTheTorqueOfUnitAccelerations) {
  const urdf::Robot robot = std::get<urdf::Robot>(urdf::parse(test::crooked_arm()));
  const Chain chain =
      with_load(std::get<Chain>(make_chain(robot, "l0", "l9")),
                {2.0, Eigen::Vector3d(0.1, 0.0, 0.2), 0.01 * Eigen::Matrix3d::Identity()});
  const Eigen::Index n = chain.joints();
  const Rows q = random_rows(1, n, 4);
  const Rows zero = Rows::Zero(n, n);
  const Rows torques = Dynamics(chain).torques(q.replicate(n, 1), zero, Rows::Identity(n, n),
                                               Eigen::Vector3d::Zero());
  const Rows mass = Dynamics(chain).mass_matrices(q);
  EXPECT_LE((Eigen::Map<const Rows>(mass.data(), n, n) - torques).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace leadthrough::dynamics_tests
