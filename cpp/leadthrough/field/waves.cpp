#include "leadthrough/field/waves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "leadthrough/field/sparse_march.hpp"

namespace leadthrough {

namespace {

double arrival_at(const PathEnd& end, const CellSet& blocks, const std::vector<double>& times) {
  const std::optional<Source> first = first_of(end, blocks, times);
  return first ? first->time : std::numeric_limits<double>::infinity();
}

// A wave does not include the distance from a block's centre to an end in it.
double unseen_at(const PathEnd& end, const CellSet& blocks, const double* speed, double reach) {
  return end.is_outside ? 0.0 : reach / speed[blocks.find(end.entries.front().cell)];
}

}  // namespace

std::optional<Source> first_of(const PathEnd& end, const CellSet& cells,
                               const std::vector<double>& times) {
  std::optional<Source> first;
  for (const Source& entry : end.entries) {
    const CellSet::Place place = cells.find(entry.cell);
    if (place == cells.missing() || std::isinf(times[place])) continue;
    const double time = times[place] + entry.time;
    if (!first || time < first->time) first = Source{entry.cell, time};
  }
  return first;
}

Waves waves_between(const CellSet& blocks, const double* speed, const PathEnd& start,
                    const PathEnd& goal, double reach) {
  std::vector<double> through = march_second_order(blocks, speed, start.entries);
  const std::vector<double> from_goal = march_second_order(blocks, speed, goal.entries);
  // The two waves' times differ by the scheme's error, which is largest at the mouths of tubes.
  const double arrival =
      std::max(arrival_at(start, blocks, from_goal), arrival_at(goal, blocks, through));
  const double unseen =
      unseen_at(start, blocks, speed, reach) + unseen_at(goal, blocks, speed, reach);
  std::transform(through.begin(), through.end(), from_goal.begin(), through.begin(),
                 [&](double there, double back) { return there + back - unseen; });
  return {std::move(through), arrival, blocks.is_open(from_goal.data())};
}

}  // namespace leadthrough
