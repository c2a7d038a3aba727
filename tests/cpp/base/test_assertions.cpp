#if defined(__SANITIZE_ADDRESS__)
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <vector>

namespace leadthrough {
namespace {

TEST(SanitizedBuild, AssertsWhatEigenAndTheStandardLibraryRequire) {
  const Eigen::VectorXd three = Eigen::VectorXd::Zero(3);
  const std::vector<double> empty;
  EXPECT_DEATH(static_cast<void>(three(three.size())), "Assertion");
  EXPECT_DEATH(static_cast<void>(empty.front()), "Assertion");
}

}  // namespace
}  // namespace leadthrough
#endif
