#include "leadthrough/field/quickest.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/field/descent.hpp"
#include "leadthrough/field/sparse_march.hpp"

namespace leadthrough {

namespace {

// Maps of fewer blocks are marched as a whole.
constexpr Index kMaxBlocks = 2000;
// A limit exceeds the blocks' lower bound by this fraction, times two for every level: the smaller
// the blocks, the more obstacles they resolve.
constexpr double kHope = 0.0175;
// Relative error by which the scheme may overestimate a wave's time.
constexpr double kError = 0.01;
// A limit at which obstacles separate the ends in the band grows by this factor.
constexpr double kGrowth = 1.5;
// Radius of exact times about the goal in cells, the same as in full marches.
constexpr double kBall = 8.0;
// Width of the border of blocks about those that the quickest path may pass, in their edges: the
// scheme's gradients at the band's border are those of a wall.
constexpr double kRoom = 1.5;
constexpr double kStep = 0.5;           // of the descent, in cells
constexpr double kMaxDistance = 1e150;  // between the ends; squares of larger ones overflow

constexpr double kInfinite = std::numeric_limits<double>::infinity();

double smallest_spacing(const Blocks& blocks) {
  return *std::min_element(blocks.grid.spacing.begin(), blocks.grid.spacing.end());
}

double largest_spacing(const Blocks& blocks) {
  return *std::max_element(blocks.grid.spacing.begin(), blocks.grid.spacing.end());
}

std::vector<Index> united(const std::vector<Index>& cells, const std::vector<Index>& more) {
  std::vector<Index> result;
  result.reserve(cells.size() + more.size());
  std::set_union(cells.begin(), cells.end(), more.begin(), more.end(), std::back_inserter(result));
  return result;
}

// An end of a path, in a cell or outside the grid.
struct End {
  Point place;
  std::optional<Index> cell;
};

double distance(const Point& a, const Point& b) {
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return std::sqrt(x * x + y * y + z * z);
}

// Entry through which an outside wave first reaches an endpoint of a path.
struct PathEnd {
  std::vector<Source> entries;
  bool is_outside;  // beyond the blocks; otherwise there is exactly one entry
};

// Entry through which an outside wave first reaches an endpoint, and its time; empty if
// unreachable.
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

double arrival_at(const PathEnd& end, const CellSet& blocks, const std::vector<double>& times) {
  const std::optional<Source> first = first_of(end, blocks, times);
  return first ? first->time : kInfinite;
}

// A wave does not include the distance from a block's centre to an end in it.
double unseen_at(const PathEnd& end, const CellSet& blocks, const double* speed, double reach) {
  return end.is_outside ? 0.0 : reach / speed[blocks.find(end.entries.front().cell)];
}

struct Waves {
  std::vector<double> through;  // least times from end to end through each block of the set
  double arrival;               // the later one of both waves'; infinite if there is no path
  bool is_open;                 // a path may exist beyond these blocks
};

// Waves from both ends of a path through blocks: lower bounds of path times through each block.
// speed: of each block, above 0 at ends that lie in one. reach: as of `Blocks`.
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

// The search for the band that holds the quickest path to a goal in the grid.
class Search {
 public:
  Search(const SpeedMap& map, const Point& start, const Point& goal);

  // Empty where obstacles separate the ends.
  std::vector<Point> path();

 private:
  // Waves through blocks, and the blocks.
  struct Seen {
    std::vector<Index> numbers;  // of the blocks
    Waves waves;
  };

  std::optional<std::vector<Index>> find_band();
  const Seen& look(const Blocks& blocks, const std::vector<Index>& numbers);
  bool march(const std::vector<Index>& band, std::vector<Point>& path);
  const std::vector<double>& ask(CellSet cells);
  std::vector<Point> follow(const std::vector<double>& times, const Point& first) const;
  PathEnd enter(const End& end, const Blocks& blocks, const std::vector<Index>& numbers) const;
  std::vector<Source> face(const Point& place, const Blocks& blocks,
                           const std::vector<Index>& numbers) const;
  bool holds(double arrival, double hope, bool is_open);

  const SpeedMap& map_;
  End start_;
  End goal_;
  std::vector<Blocks> levels_;  // from the coarsest to the cells
  double least_ = 0.0;          // of all limits
  double limit_ = kInfinite;    // the lowest one above which blocks were left out
  bool is_whole_ = true;        // whether the band holds every cell
  bool is_separated_ = false;   // whether obstacles are known to separate the ends
  std::map<int, Seen> seen_;    // at last, at each level
  CellSet asked_;               // cells of the latest query of the map ...
  std::vector<double> speeds_;  // ... and their speeds
};

Search::Search(const SpeedMap& map, const Point& start, const Point& goal)
    : map_(map),
      start_{start, map.cells().find(start)},
      goal_{goal, map.cells().find(goal)},
      asked_(map.cells().grid, {}) {
  int top = 0;
  while (blocks_of(map.cells(), top).grid.size() > kMaxBlocks) ++top;
  for (int level = top; level >= 0; --level) levels_.push_back(blocks_of(map.cells(), level));
}

std::vector<Point> Search::path() {
  std::vector<Index> marched;
  std::vector<Point> path;
  for (bool is_found = false; !is_found && !is_separated_;) {
    check_interrupt();
    const std::optional<std::vector<Index>> band = find_band();
    if (!band) continue;
    // With a higher limit the band may still be the same one.
    is_found = !path.empty() && *band == marched;
    if (is_found) break;
    marched = *band;
    is_found = march(*band, path);
  }
  if (is_separated_) path.clear();
  return path;
}

// The cells that the quickest path may pass; none if a limit was too low.
std::optional<std::vector<Index>> Search::find_band() {
  is_whole_ = true;
  limit_ = kInfinite;
  std::vector<Index> numbers(static_cast<std::size_t>(levels_.front().grid.size()));
  std::iota(numbers.begin(), numbers.end(), Index(0));
  for (std::size_t n = 0; n + 1 < levels_.size(); ++n) {
    const Blocks &blocks = levels_[n], &finer = levels_[n + 1];
    const Seen& seen = look(blocks, numbers);
    const double hope = kHope * static_cast<double>(Index(1) << blocks.level);
    if (!holds(seen.waves.arrival, hope, seen.waves.is_open)) return std::nullopt;
    limit_ = std::min(limit_, std::max(least_, seen.waves.arrival * (1.0 + hope)));
    std::vector<Index> kept;
    for (std::size_t k = 0; k < seen.numbers.size(); ++k)
      if (seen.waves.through[k] <= limit_) kept.push_back(seen.numbers[k]);
    if (finer.level == 0) kept = cells_within(blocks.grid, kept, kRoom * largest_spacing(blocks));
    is_whole_ = is_whole_ && static_cast<Index>(kept.size()) == blocks.grid.size();
    numbers = finer_cells(blocks.grid, finer.grid, kept);
  }
  return numbers;
}

// Waves from both ends through given blocks.
const Search::Seen& Search::look(const Blocks& blocks, const std::vector<Index>& numbers) {
  const auto known = seen_.find(blocks.level);
  // With a higher limit the blocks may still be the same ones.
  if (known != seen_.end() && known->second.numbers == numbers) return known->second;
  const CellSet cells(blocks.grid, numbers);
  const std::vector<double> speeds = map_.fastest(blocks, numbers);
  Waves waves = waves_between(cells, speeds.data(), enter(start_, blocks, numbers),
                              enter(goal_, blocks, numbers), blocks.reach);
  return seen_.insert_or_assign(blocks.level, Seen{numbers, std::move(waves)}).first->second;
}

// Sets the quickest path among given cells, none if they separate the ends; true if the limit was
// high enough for it.
bool Search::march(const std::vector<Index>& band, std::vector<Point>& path) {
  const Blocks& cells = levels_.back();
  const PathEnd start = enter(start_, cells, band), goal = enter(goal_, cells, band);
  const double radius = kBall * smallest_spacing(cells);
  const std::vector<double>& speeds =
      ask(CellSet(cells.grid, united(band, cells_within(cells.grid, {*goal_.cell}, radius))));
  const std::vector<double> times = march_second_order(
      asked_, speeds.data(), with_ball(asked_, speeds.data(), goal.entries.front(), kBall),
      start_.cell.value_or(kNoStop));
  const std::optional<Source> first = first_of(start, asked_, times);
  path.clear();
  const bool is_found =
      holds(first ? first->time : kInfinite, kError, asked_.is_open(times.data()));
  if (first) path = follow(times, start_.cell ? start_.place : cells.centre(first->cell));
  return is_found;
}

// Speeds of a band's cells; those of the latest query are reused.
const std::vector<double>& Search::ask(CellSet cells) {
  std::vector<Index> unknown;
  for (const Index cell : cells.cells())
    if (asked_.find(cell) == asked_.missing()) unknown.push_back(cell);
  const std::vector<double> found = map_.at(unknown);
  std::vector<double> speeds(cells.size());
  auto next = found.begin();
  std::transform(cells.cells().begin(), cells.cells().end(), speeds.begin(), [&](Index cell) {
    const CellSet::Place place = asked_.find(cell);
    return place == asked_.missing() ? *next++ : speeds_[place];
  });
  asked_ = std::move(cells);
  speeds_ = std::move(speeds);
  return speeds_;
}

// Descent of the times in the cells of the latest query, from a point in one of them.
std::vector<Point> Search::follow(const std::vector<double>& times, const Point& first) const {
  const Blocks& cells = levels_.back();
  const auto coordinates = [&](const Point& point) {
    Coordinates result;
    for (std::size_t axis = 0; axis < 3; ++axis)
      result[axis] = (point[axis] - cells.first[axis]) / cells.grid.spacing[axis];
    return result;
  };
  const Descent descent =
      descend(asked_, times.data(), coordinates(first), coordinates(goal_.place), kStep);
  if (descent.status != DescentStatus::kOk)
    throw std::logic_error("a cell that was reached does not lead down to the source");
  std::vector<Point> path;
  if (!start_.cell) path.push_back(start_.place);
  for (const Coordinates& at : descent.path) {
    Point& point = path.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis)
      point[axis] = cells.first[axis] + at[axis] * cells.grid.spacing[axis];
  }
  path[start_.cell ? 0 : 1] = first;
  path.back() = goal_.place;
  return path;
}

// Blocks where the wave of an end enters: the block that contains the end, or those on the border
// that face an end outside.
PathEnd Search::enter(const End& end, const Blocks& blocks,
                      const std::vector<Index>& numbers) const {
  if (end.cell) return {{{block_around(blocks, map_.cells(), *end.cell)}}, false};
  return {face(end.place, blocks, numbers), true};
}

// Times count from the wave's first entry into the grid: the distance to it is common to all.
std::vector<Source> Search::face(const Point& place, const Blocks& blocks,
                                 const std::vector<Index>& numbers) const {
  const Blocks& cells = map_.cells();
  Point nearest = place;
  std::array<bool, 3> is_before, is_after;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double first = cells.first[axis];
    const double last =
        first + cells.grid.spacing[axis] * static_cast<double>(cells.grid.shape[axis] - 1);
    is_before[axis] = place[axis] < first;
    is_after[axis] = place[axis] > last;
    nearest[axis] = std::clamp(place[axis], first, last);
  }
  std::vector<Source> entries;
  for (const Index number : numbers) {
    const std::array<Index, 3> at = blocks.place(number);
    const auto faces = [&](std::size_t axis) {
      return (at[axis] == 0 && is_before[axis]) ||
             (at[axis] == blocks.grid.shape[axis] - 1 && is_after[axis]);
    };
    if (!faces(0) && !faces(1) && !faces(2)) continue;
    const double away = distance(blocks.centre(number), place) - blocks.reach;
    entries.push_back({number, std::max(away - distance(nearest, place), 0.0) / map_.outside()});
  }
  return entries;
}

// True if no quicker path leaves the band; if one may, the next limits are higher.
bool Search::holds(double arrival, double hope, bool is_open) {
  if (std::isinf(arrival)) {
    is_separated_ = is_whole_ || !is_open;
    least_ = kGrowth * limit_;
    return false;
  }
  if (is_whole_ || arrival * (1.0 + kError) <= limit_) return true;
  least_ = arrival * (1.0 + hope);
  return false;
}

}  // namespace

Quickest quickest_path(const SpeedMap& map, const Point& start, const Point& goal) {
  check_argument(distance(start, goal) < kMaxDistance, "an end is too far away, or no number");
  const std::optional<Index> first = map.cells().find(start), last = map.cells().find(goal);
  const auto is_wall = [&](const std::optional<Index>& cell) {
    return cell && map.at({*cell}).front() == 0.0;
  };
  if (is_wall(first)) return {QuickestStatus::kStartInWall, {}};
  if (is_wall(last)) return {QuickestStatus::kGoalInWall, {}};
  std::vector<Point> path =
      last ? Search(map, start, goal).path() : Search(map, goal, start).path();
  if (!last) std::reverse(path.begin(), path.end());
  return {path.empty() ? QuickestStatus::kSeparated : QuickestStatus::kFound, std::move(path)};
}

}  // namespace leadthrough
