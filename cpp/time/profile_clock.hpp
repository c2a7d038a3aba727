#pragma once

#include <vector>

#include "time/path_grid.hpp"
#include "time/reachability.hpp"

namespace leadthrough {

// When a motion of given squared speeds, linear in the length between points of the grid, is where.
// Before its start and after its end it goes on at the speeds that it has there.
class ProfileClock {
 public:
  ProfileClock() = default;
  ProfileClock(const PathGrid& grid, const SpeedProfile& profile);

  double total() const { return times_.back(); }
  double time(Eigen::Index point) const { return times_[static_cast<std::size_t>(point)]; }
  // `cell` is where the search starts, no later than the time, and what it found.
  double length_at(double time, Eigen::Index& cell) const;

 private:
  const PathGrid* grid_ = nullptr;
  Eigen::VectorXd speeds_;
  std::vector<double> times_{0.0};
};

// Means of `width` neighbours, in place; as many fewer values.
void average(std::vector<double>& values, Eigen::Index width);

}  // namespace leadthrough
