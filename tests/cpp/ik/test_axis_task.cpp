#include <gtest/gtest.h>

#include <random>

#include "arm/robots.hpp"
#include "leadthrough/ik/axis_task.hpp"

namespace leadthrough::axis_task_tests {

namespace {

struct Case {
  IkTarget target;
  JointArray q{};
};

Case random_case(std::mt19937& generator, const Chain& chain) {
  std::uniform_real_distribution<double> uniform(-1.5, 1.5);
  Case c;
  for (int i = 0; i < chain.joints(); ++i) c.q[static_cast<std::size_t>(i)] = uniform(generator);
  c.target.position = {uniform(generator), uniform(generator), uniform(generator)};
  c.target.rotation = so3::to_matrix(
      so3::exp(Eigen::Vector3d(uniform(generator), uniform(generator), uniform(generator))));
  return c;
}

// Each of the 63 ways to leave axes free, weights and all.
template <typename Visit>
void for_all_axes(const Visit& visit) {
  for (unsigned bits = 0; bits < 63; ++bits) {
    IkAxes axes;
    for (std::size_t k = 0; k < 6; ++k) axes.free[k] = (bits >> k & 1U) != 0;
    axes.weight << 1.0, 2.0, 0.5, 3.0, 1.5, 0.7;
    visit(axes);
  }
}

}  // namespace

TEST(AxisTask, TheColumnsAreTheErrorsDerivatives) {
  const Chain chain = test::crooked_chain();
  std::mt19937 generator(1);
  constexpr double kStep = 1e-6;
  for_all_axes([&](const IkAxes& axes) {
    for (int repeat = 0; repeat < 5; ++repeat) {
      const Case c = random_case(generator, chain);
      visit_target(c.target, axes, [&](auto dimension, const auto& target) {
        Task<decltype(dimension)::value> here, before, after;
        evaluate(chain, target, c.q.data(), here);
        if (here.orientation_error > 2.5) return;  // no derivative at half a turn
        for (std::size_t i = 0; i < static_cast<std::size_t>(chain.joints()); ++i) {
          JointArray q = c.q;
          q[i] = c.q[i] - kStep;
          evaluate(chain, target, q.data(), before);
          q[i] = c.q[i] + kStep;
          evaluate(chain, target, q.data(), after);
          const auto slope = ((before.error - after.error) / (2.0 * kStep)).eval();
          EXPECT_LE((slope - here.columns[i]).norm(), 1e-7 * (1.0 + slope.norm()));
        }
      });
    }
  });
}

TEST(AxisTask, ASpinAboutTheFreeAxisIsNoError) {
  const Chain chain = test::crooked_chain();
  std::mt19937 generator(2);
  for (int k = 0; k < 3; ++k) {
    IkAxes axes;
    axes.free[static_cast<std::size_t>(3 + k)] = true;
    for (const double spin : {0.0, 1.0, 3.0, -3.1}) {
      const Case c = random_case(generator, chain);
      const Transform pose = forward_kinematics(chain, c.q.data());
      const Eigen::Matrix3d turn = so3::to_matrix(so3::exp(spin * Eigen::Vector3d::Unit(k)));
      const IkTarget target{pose.position, pose.rotation * turn};
      Task<6> task;
      evaluate(chain, AxisTarget(target, axes), c.q.data(), task);
      EXPECT_LE(task.error.norm(), 1e-12);
    }
  }
}

TEST(AxisTask, MeasuresStayFiniteWhereTheyHaveNoDirection) {
  for (int k = 0; k < 3; ++k) {
    for (const double tilt : {0.0, 1e-13, 1e-9}) {
      const Eigen::Vector3d across = Eigen::Vector3d::Unit((k + 1) % 3);
      const Eigen::Matrix3d rotation = so3::to_matrix(so3::exp((3.14159265358979 - tilt) * across));
      for (const RotationError& error :
           {rotation_vector_error(rotation), swing(rotation, k), twist(rotation, k)}) {
        EXPECT_TRUE(error.error.allFinite() && error.rate.allFinite());
      }
      EXPECT_NEAR(swing(rotation, k).error.norm(), 3.14159265358979 - tilt, 1e-7);
    }
  }
}

TEST(AxisTask, AllAxesAlikeMeasureAsThePlainTask) {
  const Chain chain = test::crooked_chain();
  std::mt19937 generator(3);
  for (int repeat = 0; repeat < 50; ++repeat) {
    const Case c = random_case(generator, chain);
    Task<6> plain, by_axes;
    evaluate(chain, c.target, c.q.data(), plain);
    evaluate(chain, AxisTarget(c.target, IkAxes()), c.q.data(), by_axes);
    EXPECT_NEAR(plain.position_error, by_axes.position_error, 1e-12);
    EXPECT_NEAR(plain.orientation_error, by_axes.orientation_error, 1e-9);
    EXPECT_NEAR(plain.squared(), by_axes.squared(), 1e-9);
  }
}

}  // namespace leadthrough::axis_task_tests
