#include <gtest/gtest.h>

#include "leadthrough/learn/basis_functions.hpp"

namespace leadthrough::basis_functions_tests {

namespace {

constexpr double kTurn = 2.0 * EIGEN_PI;

double basis_function(double u, double centre, double sharpness, bool periodic) {
  const double d = u - centre;
  return std::exp(periodic ? sharpness * (std::cos(kTurn * d) - 1.0) : -0.5 * sharpness * d * d);
}

}  // namespace

TEST(Bells, AreExponentialsOverTheirSum) {
  const Eigen::VectorXd centres = Eigen::VectorXd::LinSpaced(7, -0.2, 1.2);
  const Eigen::VectorXd phases = Eigen::VectorXd::LinSpaced(5, 0.0, 1.0);
  for (const bool periodic : {false, true}) {
    const auto found = normalised_basis(phases, centres, 9.0, periodic, 0);
    for (Eigen::Index i = 0; i < phases.size(); ++i) {
      double total = 0.0;
      for (const double c : centres) total += basis_function(phases[i], c, 9.0, periodic);
      for (Eigen::Index j = 0; j < centres.size(); ++j)
        EXPECT_NEAR(found(i, j), basis_function(phases[i], centres[j], 9.0, periodic) / total,
                    1e-14);
    }
  }
}

TEST(Bells, DerivativesAreThoseOfCentralDifferences) {
  const Eigen::VectorXd centres = Eigen::VectorXd::LinSpaced(7, -0.2, 1.2);
  const Eigen::VectorXd phases = Eigen::VectorXd::LinSpaced(9, 0.0, 1.0);
  const double step = 1e-6;
  for (const bool periodic : {false, true})
    for (const int order : {1, 2}) {
      const auto ahead = normalised_basis(phases.array() + step, centres, 9.0, periodic, order - 1);
      const auto behind =
          normalised_basis(phases.array() - step, centres, 9.0, periodic, order - 1);
      const auto found = normalised_basis(phases, centres, 9.0, periodic, order);
      EXPECT_LT((found - (ahead - behind) / (2.0 * step)).cwiseAbs().maxCoeff(), 1e-6);
    }
}

TEST(Bells, WithDerivativesAreThoseOfEachOrder) {
  const Eigen::VectorXd centres = Eigen::VectorXd::LinSpaced(7, -0.2, 1.2);
  const Eigen::VectorXd phases = Eigen::VectorXd::LinSpaced(9, 0.0, 1.0);
  for (const bool periodic : {false, true})
    for (const int most : {0, 1, 2}) {
      const Rows all = basis_and_derivatives(phases, centres, 9.0, periodic, most);
      ASSERT_EQ(all.rows(), (most + 1) * 9);
      for (int order = 0; order <= most; ++order) {
        const Rows one = normalised_basis(phases, centres, 9.0, periodic, order);
        EXPECT_TRUE((all.middleRows(order * 9, 9).array() == one.array()).all());
      }
    }
}

}  // namespace leadthrough::basis_functions_tests
