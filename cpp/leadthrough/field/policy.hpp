#pragma once

// A policy from a field of arrival times: the velocity at any position, down the field's gradient
// at the demonstrated speed. Prados et al. 2023, section 3.7.

#include <memory>
#include <optional>
#include <variant>

#include "leadthrough/base/matrix.hpp"
#include "leadthrough/field/descent.hpp"

namespace leadthrough {

// A disc across the start of a motion that returns there: the field leads around it.
struct StartBarrier {
  Eigen::VectorXd middle, normal;  // normal: a unit vector along the path
  double width, thickness;         // half of the disc's
};

// In two or three dimensions d.
struct PolicyTables {
  Eigen::VectorXd shape, spacing, origin;  // (d) of the grid; origin: centre of the first cell
  std::variant<const float*, const double*> arrival;  // times in the cells, in C order
  std::shared_ptr<const void> owner;                  // of their memory
  Eigen::VectorXd goal;                               // (d)
  Rows positions;                                     // (n, d) along the demonstrations
  Eigen::VectorXd speeds;                             // (n) there
  double mean_speed = 0.0;
  double slowing = 0.0;  // distance from the goal at which the mean speed falls
  std::optional<StartBarrier> barrier;
};

class MarchingPolicy {
 public:
  using PositionIn = VectorRef;
  using PositionOut = Eigen::Ref<Eigen::VectorXd>;

  // Throws std::invalid_argument for sizes that disagree, and so do the members.
  explicit MarchingPolicy(const PolicyTables& tables);

  Eigen::VectorXd goal() const { return goal_.tail(dimensions_); }
  // Writes the velocity at a position, per second; 0 at the goal. Statuses other than kOk are those
  // of `direction`: there is none in obstacles and outside the field.
  DescentStatus velocity(const PositionIn& position, PositionOut result) const;
  // Moves a position by the velocities of dt s; where there is none on the way, the position is
  // the one that has none.
  DescentStatus step(double dt, PositionOut position) const;

 private:
  struct Barrier {
    Eigen::Vector3d middle, normal;
    double width, thickness;
    bool contains(const Eigen::Vector3d& point) const;
    bool is_passed(const Eigen::Vector3d& point) const;
  };

  Eigen::Vector3d padded(const PositionIn& position) const;
  double farther_than_nearest(const Eigen::Vector3d& point) const;
  double speed_at(const Eigen::Vector3d& point) const;
  DescentStatus descend(const Eigen::Vector3d& point, Eigen::Vector3d& unit) const;
  DescentStatus velocity_at(const Eigen::Vector3d& point, Eigen::Vector3d& velocity) const;

  // In two dimensions the first coordinate of all points and vectors is 0.
  Eigen::Index dimensions_;
  Grid grid_;
  Eigen::Vector3d spacing_, origin_, goal_;
  double cell_;
  std::variant<const float*, const double*> arrival_;
  std::shared_ptr<const void> owner_;
  double mean_speed_, slowing_;
  Eigen::Matrix3Xd positions_;
  Eigen::VectorXd speeds_;
  std::optional<Barrier> barrier_;
};

}  // namespace leadthrough
