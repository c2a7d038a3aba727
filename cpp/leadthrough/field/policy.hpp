#pragma once

// A policy from a field of arrival times: the velocity at any position, down the field's gradient
// at the demonstrated speed. Prados et al. 2023, section 3.7.

#include <Eigen/Core>
#include <optional>
#include <variant>

#include "leadthrough/field/descent.hpp"

namespace leadthrough {

// A disc across the start of a motion that returns there: the field leads around it.
struct StartBarrier {
  Eigen::Vector3d middle, normal;  // normal: a unit vector along the path
  double width, thickness;         // half of the disc's
};

// In two dimensions the first coordinate of all points and vectors is 0.
struct Policy {
  Grid grid;
  Eigen::Vector3d origin;  // centre of the first cell
  std::variant<const float*, const double*> arrival;
  Eigen::Vector3d goal;
  double mean_speed;
  double slowing;              // distance from the goal at which the mean speed falls
  Eigen::Matrix3Xd positions;  // at least one, along the demonstrations
  Eigen::VectorXd speeds;      // there
  std::optional<StartBarrier> barrier;
};

// Velocity at a point, per second; 0 at the goal. Statuses other than kOk are those of `direction`.
DescentStatus velocity_at(const Policy& policy, const Eigen::Vector3d& point,
                          Eigen::Vector3d& velocity);

// Moves a point by the velocities of a time, s. With another status than kOk, the point is the one
// that has no velocity.
DescentStatus follow(const Policy& policy, double span, Eigen::Vector3d& point);

}  // namespace leadthrough
