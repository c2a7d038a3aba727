#include "leadthrough/time/profile_clock.hpp"

#include <algorithm>

#include "leadthrough/base/interrupt.hpp"

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

LawSamples ProfileClock::smoothed(double period, Index first, Index count) const {
  LawSamples result;
  for (std::vector<double>* values : {&result.length, &result.speed, &result.push})
    values->resize(static_cast<std::size_t>(count));
  Index cell = 0, steps = 0;
  double begin = static_cast<double>(first - 1) * period;
  double before = length_at(begin, cell), here = 0.0;
  Step last = step(begin, period, steps);
  for (Index k = 0; k < count; ++k, before = here) {
    check_interrupt(k);
    begin = static_cast<double>(first + k) * period;
    here = length_at(begin, cell);
    const Step next = step(begin, period, steps);
    const auto at = static_cast<std::size_t>(k);
    result.length[at] =
        0.5 * (before + here) + (last.moment / period + next.area - next.moment / period) / period;
    result.speed[at] = (last.rise + (next.area - last.area) / period) / period;
    result.push[at] = (next.rise - last.rise) / (period * period);
    last = next;
  }
  return result;
}

ProfileClock::Step ProfileClock::step(double begin, double period, Index& cell) const {
  const double end = begin + period;
  const Index cells = grid_->points() - 1;
  Step result;
  Index turn = 1;  // most steps have few
  for (double from = begin; from < end; ++turn) {
    check_interrupt(turn);
    double to = end, speed = 0.0, push = 0.0;
    if (from < 0.0) {
      to = std::min(end, 0.0);
      speed = speeds_[0];
    } else if (from >= total()) {
      speed = speeds_[cells];
    } else {
      while (time(cell + 1) <= from) ++cell;
      to = std::min(end, time(cell + 1));
      push = (speeds_[cell + 1] - speeds_[cell]) / (time(cell + 1) - time(cell));
      speed = speeds_[cell] + push * (from - time(cell));
    }
    const double w = to - from, rise = result.rise, squared = w * w;
    const double area = rise * w + squared * (0.5 * speed + push * w / 6.0);
    result.moment +=
        (from - begin) * area + squared * (0.5 * rise + w * (speed / 3.0 + 0.125 * push * w));
    result.area += area;
    result.rise += w * (speed + 0.5 * push * w);
    if (!(to > from)) break;  // no numbers
    from = to;
  }
  return result;
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
