#include <gtest/gtest.h>

#include <cmath>

#include "leadthrough/dmp/primitive.hpp"

namespace leadthrough::dmp::primitive_tests {

namespace {

constexpr double kRate = 12.5;

// A force of two channels that rises and falls over four intervals.
Forces wavy(Canonical canonical) {
  Forces forces{Rows(5, 2), Vector::LinSpaced(5, 1.0, 0.1), kRate, canonical};
  forces.nodes << 0, 50, 80, -20, -40, 10, 60, 0, 0, 50;
  return forces;
}

// From (0, 1) to (1, 1) with a reference that moves, a gain and a drive.
Course busy() {
  Course course{{Vector(2), Rows::Zero(6, 2)}, Vector(2), Vector(2)};
  course.reference.breaks << 0, 1;
  course.reference.coefficients.col(0) << 0, 0, 0, 10, -15, 6;
  course.reference.coefficients(0, 1) = 1.0;
  course.gain << 1.0, -0.5;
  course.drive << 3.0, 0.0;
  return course;
}

State rest() { return {Vector::Unit(2, 1), Vector::Zero(2), 0.0}; }

double linear(const Vector& table, double u) {
  const double place = std::min(u, 1.0) * 4.0;
  const auto i = std::min<Eigen::Index>(static_cast<Eigen::Index>(place), 3);
  const double s = place - static_cast<double>(i);
  return (1 - s) * table[i] + s * table[i + 1];
}

// Channel 0 by many small steps of the classical Runge-Kutta method.
Eigen::Vector2d integrated(const Forces& forces, const Course& course, double end) {
  const auto rate_of_change = [&](double u, const Eigen::Vector2d& y) {
    const double r = u * u * u * (10 + u * (6 * u - 15));
    const double r1 = 30 * u * u * (1 - u) * (1 - u);
    const double r2 = 60 * u * (1 - u) * (1 - 2 * u);
    const double force =
        course.gain[0] * linear(forces.nodes.col(0), u) + course.drive[0] * linear(forces.fade, u);
    return Eigen::Vector2d(y[1], r2 - 2 * kRate * (y[1] - r1) - kRate * kRate * (y[0] - r) + force);
  };
  constexpr int kSteps = 20000;
  const double h = end / kSteps;
  Eigen::Vector2d y(0, 0);
  for (int i = 0; i < kSteps; ++i) {
    const double u = i * h;
    const Eigen::Vector2d k1 = rate_of_change(u, y);
    const Eigen::Vector2d k2 = rate_of_change(u + h / 2, y + h / 2 * k1);
    const Eigen::Vector2d k3 = rate_of_change(u + h / 2, y + h / 2 * k2);
    const Eigen::Vector2d k4 = rate_of_change(u + h, y + h * k3);
    y += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return y;
}

TEST(Dmp, AgreesWithRungeKutta) {
  const Forces forces = wavy(Canonical::kDiscrete);
  for (const double end : {0.1, 0.25, 0.6, 1.0}) {
    State state = rest();
    advance(forces, busy(), Vector::Zero(2), end, state);
    const Eigen::Vector2d truth = integrated(forces, busy(), end);
    EXPECT_NEAR(state.value[0], truth[0], 1e-9) << end;
    EXPECT_NEAR(state.slope[0], truth[1], 1e-7) << end;
  }
}

TEST(Dmp, StepsOfAnyLengthGiveTheSameMotion) {
  for (const Canonical canonical : {Canonical::kDiscrete, Canonical::kRhythmic}) {
    const Forces forces = wavy(canonical);
    State at_once = rest();
    advance(forces, busy(), Vector::Zero(2), 2.3, at_once);
    for (const int steps : {3, 10, 230, 4567}) {
      State state = rest();
      for (int i = 0; i < steps; ++i) advance(forces, busy(), Vector::Zero(2), 2.3 / steps, state);
      EXPECT_LT((state.value - at_once.value).norm(), 1e-10) << steps;
      EXPECT_LT((state.slope - at_once.slope).norm(), 1e-8) << steps;
    }
  }
}

TEST(Dmp, AConstantPushMovesTheRestByPushOverStiffness) {
  State state = rest();
  advance(wavy(Canonical::kDiscrete), busy(), Vector::Constant(2, 15.625), 100.0, state);
  EXPECT_NEAR(state.value[0], 1.1, 1e-12);
  EXPECT_NEAR(state.value[1], 1.1, 1e-12);
}

TEST(Dmp, RhythmicMotionRepeats) {
  const Forces forces = wavy(Canonical::kRhythmic);
  Course centre{{busy().reference.breaks, Rows::Zero(6, 2)}, Vector::Ones(2), Vector::Zero(2)};
  State state = rest();
  advance(forces, centre, Vector::Zero(2), 5.0, state);
  const State before = state;
  advance(forces, centre, Vector::Zero(2), 1.0, state);
  EXPECT_LT((state.value - before.value).norm(), 1e-12);
}

TEST(Dmp, PiecesOfAReferenceJoin) {
  Course course{{Vector(3), Rows::Zero(12, 1)}, Vector::Ones(1), Vector::Zero(1)};
  course.reference.breaks << 0, 0.5, 1;
  course.reference.coefficients(1, 0) = 2.0;  // from 0 to 1 at even speed
  course.reference.coefficients(6, 0) = 1.0;  // then rest
  const Forces still{Rows::Zero(2, 1), Vector::Zero(2), kRate, Canonical::kDiscrete};
  const Vector phases = Vector::LinSpaced(5, 0.0, 1.0);
  const Rollout result =
      rollout(still, course, {Vector::Zero(1), Vector::Constant(1, 2.0), 0.0}, phases);
  EXPECT_NEAR(result.values(1, 0), 0.5, 1e-12);
  EXPECT_NEAR(result.slopes(1, 0), 2.0, 1e-12);
  EXPECT_EQ(result.values.rows(), 5);
}

}  // namespace

}  // namespace leadthrough::dmp::primitive_tests
