#pragma once

#include <vector>

#include "leadthrough/time/limit_use.hpp"
#include "leadthrough/time/path_grid.hpp"
#include "leadthrough/time/reachability.hpp"

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

  // Weighted means over one period on both sides of the times first * period, (first + 1) * period
  // and so on, with weights that fall to 0 like a hat, and their two derivatives in time.
  LawSamples smoothed(double period, Eigen::Index first, Eigen::Index count) const;

 private:
  // Integrals over a period of the length beyond its start, of its derivative, and of it times the
  // time.
  struct Step {
    double rise = 0.0, area = 0.0, moment = 0.0;
  };
  Step step(double begin, double period, Eigen::Index& cell) const;

  const PathGrid* grid_ = nullptr;
  Eigen::VectorXd speeds_;
  std::vector<double> times_{0.0};
};

// Means of `width` neighbours, in place; as many fewer values.
void average(std::vector<double>& values, Eigen::Index width);

}  // namespace leadthrough
