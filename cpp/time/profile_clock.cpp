#include "time/profile_clock.hpp"

namespace leadthrough {

using Eigen::Index;

ProfileClock::ProfileClock(const PathGrid& grid, const SpeedProfile& profile)
    : grid_(&grid), speeds_(profile.squared.cwiseSqrt()) {
  times_.resize(static_cast<std::size_t>(grid.points()));
  times_[0] = 0.0;
  for (Index i = 0; i + 1 < grid.points(); ++i)
    times_[static_cast<std::size_t>(i + 1)] =
        time(i) + 2.0 * (grid.length[i + 1] - grid.length[i]) / (speeds_[i] + speeds_[i + 1]);
}

double ProfileClock::length_at(double time, Index& cell) const {
  if (time <= 0.0) return speeds_[0] * time;
  if (time >= total()) return grid_->end() + speeds_[speeds_.size() - 1] * (time - total());
  while (this->time(cell + 1) <= time) ++cell;
  const double t = time - this->time(cell), span = this->time(cell + 1) - this->time(cell);
  const double v0 = speeds_[cell], v1 = speeds_[cell + 1];
  return grid_->length[cell] + t * (v0 + 0.5 * t * (v1 - v0) / span);
}

void average(std::vector<double>& values, Index width) {
  const auto window = static_cast<std::size_t>(width);
  const double share = 1.0 / static_cast<double>(width);
  double sum = 0.0;
  for (std::size_t k = 0; k + 1 < window; ++k) sum += values[k];
  for (std::size_t k = 0; k + window <= values.size(); ++k) {
    sum += values[k + window - 1];
    const double oldest = values[k];
    values[k] = sum * share;
    sum -= oldest;
  }
  values.resize(values.size() - window + 1);
}

}  // namespace leadthrough
