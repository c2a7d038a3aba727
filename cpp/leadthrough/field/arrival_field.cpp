#include "leadthrough/field/arrival_field.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <type_traits>
#include <vector>

#include "leadthrough/field/bucket_march.hpp"
#include "leadthrough/field/padded_field.hpp"
#include "leadthrough/field/upwind.hpp"

namespace leadthrough {

namespace {

// A cell's time is consistent if its neighbours imply it up to this relative error. The upwind
// scheme spreads a cell's influence, ever weaker, over all later cells: without a tolerance half
// the field would be marched again for differences of rounding. Errors of at most a few hundred
// consecutive cells add up, for any number of updates, since every time is tested on neighbours.
template <typename Real>
constexpr Real kTolerance = std::is_same_v<Real, float> ? Real(4e-7) : Real(1e-10);

// Above this share of invalid cells a full march is cheaper than the repair.
constexpr Index kMaxInvalid = 4;  // one in four

template <typename Real, int D>
class RepairedField final : public ArrivalField<Real> {
 public:
  RepairedField(const Grid& grid, const Real* speed, const std::vector<Source>& sources)
      : field_(grid, speed),
        has_cubes_(field_.has_cubes()),
        fastest_(*std::max_element(speed, speed + grid.size())) {
    for (const Source& source : sources)
      sources_.push_back({field_.cell(source.cell), static_cast<Real>(source.time / field_.unit)});
    std::sort(sources_.begin(), sources_.end(), [](const Start& a, const Start& b) {
      return std::tie(a.cell, a.time) < std::tie(b.cell, b.time);
    });
    march_everything();
  }

  Update update(const Region& region, const Real* speed) override {
    rescale(*std::max_element(speed, speed + region.shape[0] * region.shape[1] * region.shape[2]));
    replace_speeds(region, speed);
    if (is_whole_ && suspects_.empty() && faster_.empty()) return {UpdateKind::kNone, 0};
    if (!is_whole_ || !invalidate()) {
      march_everything();
      return {UpdateKind::kFullMarch, static_cast<Index>(invalid_.size())};
    }
    is_whole_ = false;
    march_from_border();
    is_whole_ = true;
    return {UpdateKind::kRepair, static_cast<Index>(invalid_.size())};
  }

  std::vector<Real> times() override {
    if (!is_whole_) march_everything();
    return field_.times_up_to(kUnreached<Real>);
  }

 private:
  struct Start {
    Cell cell;
    Real time;
  };

  void rescale(Real fastest);
  void replace_speeds(const Region& region, const Real* speed);
  bool invalidate();
  void march_from_border();
  void march_everything();
  Real solve(Cell cell, Real before) const;
  bool is_consistent(Cell cell, Real time) const;

  template <typename Function>
  void with_march(MarchKind kind, Function function) {
    if (has_cubes_) {
      BucketMarch<Real, D, true> march(field_, kind);
      function(march);
    } else {
      BucketMarch<Real, D, false> march(field_, kind);
      function(march);
    }
  }

  PaddedField<Real, D> field_;
  bool has_cubes_;
  Real fastest_;  // has the step 1
  std::vector<Start> sources_;
  std::vector<Cell> suspects_;  // cells whose time may depend on an invalid one
  std::vector<Cell> faster_;
  std::vector<Cell> invalid_;
  bool is_whole_ = false;  // not since a march that was interrupted
};

// Keeps steps from falling far below 1, the quickest that the march's buckets are made for. Powers
// of two do it without rounding.
template <typename Real, int D>
void RepairedField<Real, D>::rescale(Real fastest) {
  if (fastest <= fastest_) return;
  constexpr int kMax = std::numeric_limits<Real>::max_exponent - 1;
  const int exponent = std::min(std::ilogb(fastest) - std::ilogb(fastest_) + 1, kMax);
  const Real factor = std::ldexp(Real(1), exponent);
  fastest_ *= factor;
  field_.unit /= static_cast<double>(factor);
  for (Real& step : field_.step) step *= factor;
  for (Real& time : field_.time) time *= factor;
  for (Start& source : sources_) source.time *= factor;
}

template <typename Real, int D>
void RepairedField<Real, D>::replace_speeds(const Region& region, const Real* speed) {
  suspects_.clear();
  faster_.clear();
  for (Index x = 0; x < region.shape[0]; ++x) {
    for (Index y = 0; y < region.shape[1]; ++y) {
      const Index first = field_.row(region.low[0] + x, region.low[1] + y) + region.low[2];
      for (Index cell = first; cell < first + region.shape[2]; ++cell) {
        const Real step = fastest_ / *speed++;
        const Real old = field_.step[cell];
        if (step == old) continue;
        (step > old ? suspects_ : faster_).push_back(static_cast<Cell>(cell));
        field_.step[cell] = step;
      }
    }
  }
}

// The time of a cell from its neighbours that are earlier than `before`.
template <typename Real, int D>
Real RepairedField<Real, D>::solve(Cell cell, Real before) const {
  using One = Eigen::Array<Real, 1, 1>;
  const Real* at = &field_.time[cell];
  std::array<One, D> upwind;
  Real least = kUnreached<Real>;
  for (int axis = 0; axis < D; ++axis) {
    const Index stride = field_.stride[axis];
    const Real nearest = std::min(at[-stride], at[stride]);
    upwind[axis][0] = nearest < before ? nearest : kUnreached<Real>;
    least = std::min(least, upwind[axis][0]);
  }
  const Real step = field_.step[cell];
  if (least == kUnreached<Real> || step == kUnreached<Real>) return kUnreached<Real>;
  const One steps = One::Constant(step);
  return has_cubes_ ? solve_cubes(upwind, steps)[0] : solve_boxes(upwind, field_.spacing, steps)[0];
}

// Only earlier neighbours count: two late cells could confirm each other.
template <typename Real, int D>
bool RepairedField<Real, D>::is_consistent(Cell cell, Real time) const {
  if (field_.step[cell] == kUnreached<Real>) return false;
  if (solve(cell, time) <= time * (1 + kTolerance<Real>)) return true;
  const auto source =
      std::lower_bound(sources_.begin(), sources_.end(), cell,
                       [](const Start& start, Cell sought) { return start.cell < sought; });
  return source != sources_.end() && source->cell == cell && source->time <= time;
}

// Clears the times of inconsistent suspects, and makes suspects of the neighbours that depend on
// them. False if a full march is cheaper.
template <typename Real, int D>
bool RepairedField<Real, D>::invalidate() {
  const auto most =
      static_cast<std::size_t>(field_.shape[0] * field_.shape[1] * field_.shape[2] / kMaxInvalid);
  invalid_.clear();
  std::vector<Real>& time = field_.time;
  for (std::size_t n = 0; n < suspects_.size(); ++n) {
    const Cell cell = suspects_[n];
    const Real t = time[cell];
    if (t == kUnreached<Real> || is_consistent(cell, t)) continue;
    time[cell] = kUnreached<Real>;
    invalid_.push_back(cell);
    if (invalid_.size() > most) return false;
    for (int axis = 0; axis < D; ++axis) {
      for (const Index stride : {-field_.stride[axis], field_.stride[axis]}) {
        const Index neighbour = cell + stride;
        if (time[neighbour] > t && time[neighbour] < kUnreached<Real> &&
            time[neighbour + stride] >= t)
          suspects_.push_back(static_cast<Cell>(neighbour));
      }
    }
  }
  return true;
}

template <typename Real, int D>
void RepairedField<Real, D>::march_from_border() {
  with_march(MarchKind::kRepair, [&](auto& march) {
    for (const std::vector<Cell>* cells : {&invalid_, &faster_})
      for (const Cell cell : *cells) march.start(cell, solve(cell, kUnreached<Real>));
    for (const Start& source : sources_) march.start(source.cell, source.time);
    march.run(nullptr);
  });
}

template <typename Real, int D>
void RepairedField<Real, D>::march_everything() {
  is_whole_ = false;
  std::fill(field_.time.begin(), field_.time.end(), kUnreached<Real>);
  with_march(MarchKind::kFresh, [&](auto& march) {
    for (const Start& source : sources_) march.start(source.cell, source.time);
    march.run(nullptr);
  });
  is_whole_ = true;
}

}  // namespace

template <typename Real>
std::unique_ptr<ArrivalField<Real>> make_arrival_field(const Grid& grid, const Real* speed,
                                                       const std::vector<Source>& sources) {
  if (grid.shape[0] == 1) return std::make_unique<RepairedField<Real, 2>>(grid, speed, sources);
  return std::make_unique<RepairedField<Real, 3>>(grid, speed, sources);
}

template std::unique_ptr<ArrivalField<float>> make_arrival_field(const Grid&, const float*,
                                                                 const std::vector<Source>&);
template std::unique_ptr<ArrivalField<double>> make_arrival_field(const Grid&, const double*,
                                                                  const std::vector<Source>&);

}  // namespace leadthrough
