#pragma once

// A path's points for the time law, over a parameter that grows with the motion: where the path's
// own parameter runs through a stretch without moving much, this one hardly grows.

#include <array>
#include <vector>

#include "leadthrough/time/polynomial_path.hpp"

namespace leadthrough {

struct PathGrid {
  Eigen::VectorXd scale;          // (joints,) see make_path_grid
  Eigen::VectorXd length;         // (n,) from 0
  Eigen::VectorXd s;              // (n,) the path's parameter there
  Eigen::VectorXd slope, bend;    // (n,) first and second derivative of s by length
  Rows positions, first, second;  // (n, joints) with derivatives by length

  Eigen::Index points() const { return length.size(); }
  double end() const { return length[points() - 1]; }
};

constexpr Eigen::Index kMaxGridPoints = 10'000'000;

// `points` points, closer to each other where the path turns. scale: for each joint, what counts
// as one unit of motion: the fastest that it could be, 0 for a joint that does not count. The path
// must move. also: parameters inside the path that are points too.
PathGrid make_path_grid(const PolynomialPath& path, const VectorRef& scale, Eigen::Index points,
                        const std::vector<double>& also = {});

// s by the length in a cell of the grid: the quintic through s, slope and bend of the points on
// both sides, so that the second derivative is continuous.
class CellParameter {
 public:
  struct Values {
    double s, slope, bend;  // with two derivatives by the length
  };

  // At a length, in cells near the one looked at before. Beyond the ends s continues in a straight
  // line.
  Values at(const PathGrid& grid, double length);

 private:
  void enter(const PathGrid& grid, Eigen::Index cell);

  Eigen::Index cell_ = 0, entered_ = -1;
  double per_width_ = 0.0;
  std::array<double, 6> terms_{};
};

// Joint states along the path, for lengths that change little from one to the next.
class PathStates {
 public:
  PathStates(const PolynomialPath& path, const PathGrid& grid);

  // With the length's derivatives in time.
  void move_to(double length, double speed, double push);

  const Eigen::VectorXd& position() const { return position_; }
  const Eigen::VectorXd& velocity() const { return velocity_; }
  const Eigen::VectorXd& acceleration() const { return acceleration_; }

 private:
  const PolynomialPath& path_;
  const PathGrid& grid_;
  CellParameter parameter_;
  Eigen::Index piece_ = 0;
  Eigen::VectorXd position_, velocity_, acceleration_;
};

}  // namespace leadthrough
