#include <gtest/gtest.h>

#include <random>

#include "leadthrough/ik/damped_step.hpp"

namespace leadthrough::damped_step_tests {

namespace {

// Random columns, an error and a box; every third joint cannot move.
struct Problem {
  Task<6> task;
  JointArray rest{};
  JointBox box;
};

Problem random_problem(std::mt19937& generator, int joints) {
  std::normal_distribution<double> normal;
  Problem problem;
  for (int row = 0; row < 6; ++row) problem.task.error[row] = normal(generator);
  for (int i = 0; i < joints; ++i) {
    const auto k = static_cast<std::size_t>(i);
    for (int row = 0; row < 6; ++row) problem.task.columns[k][row] = normal(generator);
    problem.rest[k] = 0.1 * normal(generator);
    problem.box.lower[k] = -0.3 * std::abs(normal(generator));
    problem.box.upper[k] = i % 3 == 2 ? problem.box.lower[k] : 0.3 * std::abs(normal(generator));
  }
  return problem;
}

}  // namespace

TEST(DampedStep, ABoxedStepMeetsTheConditionsOfOptimality) {
  std::mt19937 generator(1);
  const double damping = 1e-2;
  for (int repeat = 0; repeat < 500; ++repeat) {
    const int joints = 1 + repeat % kMaxJoints;
    const Problem problem = random_problem(generator, joints);
    const JointArray step = boxed_step(problem.task, joints, damping, problem.rest, problem.box);
    TaskVector<6> residual = problem.task.error;
    for (std::size_t i = 0; i < static_cast<std::size_t>(joints); ++i)
      residual -= step[i] * problem.task.columns[i];
    for (std::size_t i = 0; i < static_cast<std::size_t>(joints); ++i) {
      ASSERT_GE(step[i], problem.box.lower[i]);
      ASSERT_LE(step[i], problem.box.upper[i]);
      const double gradient =
          -problem.task.columns[i].dot(residual) + damping * (step[i] - problem.rest[i]);
      if (step[i] > problem.box.lower[i]) {
        EXPECT_LE(gradient, 1e-9) << repeat;
      }
      if (step[i] < problem.box.upper[i]) {
        EXPECT_GE(gradient, -1e-9) << repeat;
      }
    }
  }
}

TEST(DampedStep, RotationVectorsHoldUpToAHalfTurn) {
  std::mt19937 generator(2);
  std::normal_distribution<double> normal;
  for (const double angle : {0.0, 1e-9, 1e-3, 1.0, 3.0, 3.1405, 3.1410, 3.14159}) {
    for (int repeat = 0; repeat < 20; ++repeat) {
      const Eigen::Vector3d axis =
          Eigen::Vector3d(normal(generator), normal(generator), normal(generator)).normalized();
      const Eigen::Matrix3d turn = so3::to_matrix(so3::exp(angle * axis));
      EXPECT_LE((rotation_vector(turn) - angle * axis).norm(), 1e-12) << angle;
    }
  }
}

TEST(DampedStep, ASingularMatrixIsNotFactorised) {
  Task<3> task;
  task.columns[0] = Eigen::Vector3d(1.0, 2.0, 3.0);
  task.columns[1] = Eigen::Vector3d(1.0, 2.0, 3.0);
  const auto all = [](int) { return true; };
  EXPECT_FALSE(DampedNormal<3>(task, 2, 0.0, all).factorize(1e-9));
  EXPECT_TRUE(DampedNormal<3>(task, 2, 1e-3, all).factorize(1e-9));
}

}  // namespace leadthrough::damped_step_tests
