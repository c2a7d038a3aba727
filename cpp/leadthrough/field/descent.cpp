#include "leadthrough/field/descent.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

// Within this distance straight to the goal: the gradient is meaningless next to the source.
constexpr double kNearGoal = 1.5;  // cells, along any axis

// A step must gain this fraction of the gradient's prediction, which bounds the number of steps.
constexpr double kMinGain = 0.1;

using CellIndex = std::array<Index, 3>;

CellIndex cell_of(const Coordinates& p) {
  return {static_cast<Index>(std::floor(p[0] + 0.5)), static_cast<Index>(std::floor(p[1] + 0.5)),
          static_cast<Index>(std::floor(p[2] + 0.5))};
}

template <typename Real>
struct DenseTimes {
  const Real* times;
  double at(Index cell) const { return static_cast<double>(times[cell]); }
};

// Cells outside the set are unreached.
struct SparseTimes {
  const CellSet& set;
  const double* times;
  double at(Index cell) const {
    const CellSet::Place place = set.find(cell);
    return place == set.missing() ? kInfinity : times[place];
  }
};

template <typename Times>
class Field {
 public:
  Field(const Grid& grid, const Times& arrival)
      : grid_(grid),
        strides_(grid.strides()),
        smallest_(*std::min_element(grid.spacing.begin(), grid.spacing.end())),
        arrival_(arrival) {}

  // Infinite outside the grid.
  double at(const CellIndex& cell) const { return contains(cell) ? inside(cell) : kInfinity; }

  double inside(const CellIndex& cell) const {
    return arrival_.at(cell[0] * strides_[0] + cell[1] * strides_[1] + cell[2] * strides_[2]);
  }

  bool contains(const CellIndex& cell) const {
    for (int axis = 0; axis < 3; ++axis)
      if (cell[axis] < 0 || cell[axis] >= grid_.shape[axis]) return false;
    return true;
  }

  CellIndex earliest_neighbour(const CellIndex& cell) const;
  double interpolate(const Coordinates& p, Coordinates* gradient = nullptr) const;
  bool is_free(const Coordinates& from, const Coordinates& to) const;
  bool is_near(const Coordinates& p, const Coordinates& goal) const;
  double smallest_spacing() const { return smallest_; }
  const Grid& grid() const { return grid_; }

 private:
  Coordinates upwind_gradient(const CellIndex& cell) const;

  const Grid& grid_;
  std::array<Index, 3> strides_;
  double smallest_;
  Times arrival_;
};

// The cell itself if no neighbour across a face is earlier.
template <typename Times>
CellIndex Field<Times>::earliest_neighbour(const CellIndex& cell) const {
  CellIndex result = cell;
  double earliest = at(cell);
  for (int axis = 0; axis < 3; ++axis) {
    for (const Index side : {-1, 1}) {
      CellIndex neighbour = cell;
      neighbour[axis] += side;
      if (!(at(neighbour) < earliest)) continue;  // nor NaN
      earliest = at(neighbour);
      result = neighbour;
    }
  }
  return result;
}

// Time per distance at a cell of finite arrival, from the earlier neighbour along every axis.
template <typename Times>
Coordinates Field<Times>::upwind_gradient(const CellIndex& cell) const {
  Coordinates gradient{};
  const double here = at(cell);
  for (int axis = 0; axis < 3; ++axis) {
    CellIndex before = cell, after = cell;
    --before[axis];
    ++after[axis];
    const double left = at(before), right = at(after);
    if (std::min(left, right) >= here) continue;
    gradient[axis] = (left < right ? here - left : right - here) / grid_.spacing[axis];
  }
  return gradient;
}

// Arrival and gradient between the centres of cells, multilinear over the corners of finite
// arrival; infinite, and without a gradient, in a wall. Corners behind a wall, not joined to the
// point's cell by faces between free corners, do not count.
template <typename Times>
double Field<Times>::interpolate(const Coordinates& p, Coordinates* gradient) const {
  constexpr int kCorners = 8;
  CellIndex low{};
  Coordinates part{};
  int own = 0;
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = static_cast<Index>(std::floor(p[axis]));
    part[axis] = p[axis] - static_cast<double>(low[axis]);
    if (part[axis] >= 0.5) own |= 1 << axis;
  }
  std::array<double, kCorners> arrivals{};
  const auto corner_cell = [&](int corner) {
    return CellIndex{low[0] + (corner & 1), low[1] + (corner >> 1 & 1), low[2] + (corner >> 2)};
  };
  for (int corner = 0; corner < kCorners; ++corner) arrivals[corner] = at(corner_cell(corner));
  if (arrivals[own] == kInfinity) return kInfinity;

  const bool all = std::all_of(arrivals.begin(), arrivals.end(),
                               [](double arrival) { return arrival < kInfinity; });
  int joined = all ? (1 << kCorners) - 1 : 1 << own;
  for (int pass = 0; !all && pass < kCorners; ++pass)
    for (int corner = 0; corner < kCorners; ++corner)
      for (int axis = 0; axis < 3; ++axis)
        if (arrivals[corner] < kInfinity && (joined >> (corner ^ 1 << axis) & 1))
          joined |= 1 << corner;

  double sum = 0.0, value = 0.0;
  Coordinates slopes{};
  for (int corner = 0; corner < kCorners; ++corner) {
    if (!(joined >> corner & 1)) continue;
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis)
      weight *= corner >> axis & 1 ? part[axis] : 1.0 - part[axis];
    if (weight == 0.0) continue;
    if (gradient) {
      const Coordinates slope = upwind_gradient(corner_cell(corner));
      for (int axis = 0; axis < 3; ++axis) slopes[axis] += weight * slope[axis];
    }
    value += weight * arrivals[corner];
    sum += weight;
  }
  for (double& slope : slopes) slope /= sum;
  if (gradient) *gradient = slopes;
  return value / sum;
}

// True if a segment touches only cells of finite arrival: tests one point between any two crossings
// of cells' borders, and the end.
template <typename Times>
bool Field<Times>::is_free(const Coordinates& from, const Coordinates& to) const {
  constexpr int kMaxCrossings = 16;  // ample: a segment crosses two borders at most along an axis
  std::array<double, kMaxCrossings> crossings{0.0, 1.0};
  int count = 2;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = std::min(from[axis], to[axis]), high = std::max(from[axis], to[axis]);
    for (double border = std::floor(low + 0.5) + 0.5; border < high && count < kMaxCrossings;
         ++border)
      crossings[count++] = (border - from[axis]) / (to[axis] - from[axis]);
  }
  std::sort(crossings.begin(), crossings.begin() + count);
  for (int n = 1; n < count; ++n) {
    const double t = 0.5 * (crossings[n - 1] + crossings[n]);
    Coordinates p{};
    for (int axis = 0; axis < 3; ++axis) p[axis] = from[axis] + t * (to[axis] - from[axis]);
    if (at(cell_of(p)) == kInfinity) return false;
  }
  return at(cell_of(to)) < kInfinity;
}

template <typename Times>
bool Field<Times>::is_near(const Coordinates& p, const Coordinates& goal) const {
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(p[axis] - goal[axis]) > kNearGoal) return false;
  return true;
}

Coordinates centre(const CellIndex& cell) {
  return {static_cast<double>(cell[0]), static_cast<double>(cell[1]), static_cast<double>(cell[2])};
}

// A point `length` down the gradient; the point itself if the gradient is 0.
Coordinates moved(const Grid& grid, const Coordinates& p, const Coordinates& gradient,
                  double length) {
  const double slope = std::hypot(gradient[0], gradient[1], gradient[2]);
  Coordinates result = p;
  if (slope > 0.0)
    for (int axis = 0; axis < 3; ++axis)
      result[axis] -= length * gradient[axis] / slope / grid.spacing[axis];
  return result;
}

// One midpoint step down the gradient, halved until it lowers the arrival and meets no wall;
// `arrival` becomes that of the point, or of the new one. False if no step does.
template <typename Times>
bool step_down(const Field<Times>& field, double length, Coordinates& p, double& arrival) {
  constexpr int kHalvings = 3;
  Coordinates gradient{};
  arrival = field.interpolate(p, &gradient);
  const double slope = std::hypot(gradient[0], gradient[1], gradient[2]);
  for (int n = 0; n < kHalvings; ++n, length *= 0.5) {
    const Coordinates middle = moved(field.grid(), p, gradient, 0.5 * length);
    Coordinates direction{};
    if (field.interpolate(middle, &direction) == kInfinity) continue;
    const Coordinates next = moved(field.grid(), p, direction, length);
    const double reached = field.interpolate(next);
    if (!(reached < arrival - kMinGain * slope * length) || !field.is_free(p, next)) continue;
    p = next;
    arrival = reached;
    return true;
  }
  return false;
}

// From centre to centre of ever earlier cells until one is earlier than `arrival`. The discrete
// equation gives every cell but a source an earlier neighbour across a face, and the box of two
// such cells is free. False if a source is not earlier.
template <typename Times>
bool walk_down(const Field<Times>& field, std::vector<Coordinates>& path, double& arrival) {
  CellIndex cell = cell_of(path.back());
  do {
    const CellIndex next = field.earliest_neighbour(cell);
    if (next == cell) return false;
    cell = next;
    path.push_back(centre(cell));
    check_interrupt(path.size());
  } while (field.at(cell) >= arrival);
  arrival = field.at(cell);
  return true;
}

// True if the cells about a cell hold times; `Field` does not check them.
template <typename Times>
bool holds_times(const Field<Times>& field, const CellIndex& cell) {
  constexpr Index kReach = 3;  // a step, its interpolation and the neighbours' slopes
  CellIndex low{}, high{};
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = std::max<Index>(cell[axis] - kReach, 0);
    high[axis] = std::min(cell[axis] + kReach, field.grid().shape[axis] - 1);
  }
  bool times = true;
  for (Index i = low[0]; i <= high[0]; ++i)
    for (Index j = low[1]; j <= high[1]; ++j)
      for (Index k = low[2]; k <= high[2]; ++k) times &= field.inside({i, j, k}) >= 0.0;
  return times;
}

Coordinates stepped(const Grid& grid, const Coordinates& p, const Coordinates& unit,
                    double length) {
  Coordinates result = p;
  for (int axis = 0; axis < 3; ++axis) result[axis] += length * unit[axis] / grid.spacing[axis];
  return result;
}

// Distance between points, 0 if they differ by rounding only.
Coordinates unit_vector(const Grid& grid, const Coordinates& from, const Coordinates& to) {
  constexpr double kRounding = 1e-9;  // cells
  double farthest = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    farthest = std::max(farthest, std::abs(to[axis] - from[axis]));
  if (farthest < kRounding) return {};
  Coordinates result{};
  for (int axis = 0; axis < 3; ++axis) result[axis] = (to[axis] - from[axis]) * grid.spacing[axis];
  const double length = std::hypot(result[0], result[1], result[2]);
  for (double& part : result) part /= length;
  return result;
}

template <typename Times>
Descent descend_in(const Field<Times>& field, const Coordinates& start, const Coordinates& goal,
                   double step) {
  const Grid& grid = field.grid();
  if (!field.contains(cell_of(start))) return {DescentStatus::kStartOutside, {}};
  if (field.at(cell_of(start)) == kInfinity) return {DescentStatus::kStartUnreached, {}};
  const CellIndex source = cell_of(goal);
  if (field.at(source) == kInfinity || field.earliest_neighbour(source) != source)
    return {DescentStatus::kGoalNotSource, {}};

  Descent result{DescentStatus::kOk, {start}};
  if (start == goal) return result;
  const double length = step * field.smallest_spacing();
  // The path can wind through every cell once; its steps are halved three times at most.
  const double most = 100.0 + 20.0 * static_cast<double>(grid.size()) / std::min(step, 1.0);
  Coordinates p = start;
  double time = field.interpolate(p);
  while (!(field.is_near(p, goal) && field.is_free(p, goal))) {
    if (!(time >= 0.0)) return {DescentStatus::kNotTimes, {}};
    check_interrupt();
    if (static_cast<double>(result.path.size()) > most) return {DescentStatus::kTooManySteps, {}};
    if (step_down(field, length, p, time)) {
      result.path.push_back(p);
      continue;
    }
    if (!walk_down(field, result.path, time)) {
      const bool times = holds_times(field, cell_of(result.path.back()));
      return {times ? DescentStatus::kOtherSource : DescentStatus::kNotTimes, {}};
    }
    p = result.path.back();
  }
  if (p != goal) result.path.push_back(goal);
  return result;
}

}  // namespace

const char* name(DescentStatus status) {
  // In the order of DescentStatus.
  constexpr std::array names{"ok",           "start_outside",  "start_unreached", "goal_not_source",
                             "other_source", "too_many_steps", "not_times"};
  return names[static_cast<std::size_t>(status)];
}

template <typename Real>
Descent descend(const Grid& grid, const Real* arrival, const Coordinates& start,
                const Coordinates& goal, double step) {
  return descend_in(Field(grid, DenseTimes<Real>{arrival}), start, goal, step);
}

Descent descend(const CellSet& set, const double* arrival, const Coordinates& start,
                const Coordinates& goal, double step) {
  return descend_in(Field(set.grid(), SparseTimes{set, arrival}), start, goal, step);
}

template <typename Real>
Direction direction(const Grid& grid, const Real* arrival, const Coordinates& p) {
  constexpr double kStep = 0.5;  // cells
  const Field field(grid, DenseTimes<Real>{arrival});
  const CellIndex cell = cell_of(p);
  if (!field.contains(cell)) return {DescentStatus::kStartOutside, {}};
  if (!holds_times(field, cell)) return {DescentStatus::kNotTimes, {}};
  if (field.at(cell) == kInfinity) return {DescentStatus::kStartUnreached, {}};

  const CellIndex earlier = field.earliest_neighbour(cell);
  const double length = kStep * field.smallest_spacing();
  Coordinates next = p;
  double time = kInfinity;
  if (earlier != cell && step_down(field, length, next, time)) {
    const Coordinates along = unit_vector(grid, p, next);
    if (field.is_free(p, stepped(grid, p, along, length))) return {DescentStatus::kOk, along};
  }
  // The segment to the centre of a neighbour is free, and longer than the step.
  return {DescentStatus::kOk, unit_vector(grid, p, centre(earlier))};
}

template Descent descend(const Grid&, const float*, const Coordinates&, const Coordinates&, double);
template Descent descend(const Grid&, const double*, const Coordinates&, const Coordinates&,
                         double);
template Direction direction(const Grid&, const float*, const Coordinates&);
template Direction direction(const Grid&, const double*, const Coordinates&);

}  // namespace leadthrough
