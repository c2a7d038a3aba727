#include "leadthrough/field/nearest_source.hpp"

#include <algorithm>
#include <array>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

constexpr std::int32_t kNone = -1;
constexpr std::int32_t kUnknown = -2;

// A cell's fractions from the two sources that contribute most; they sum to 1.
//
// A label copied from the earliest neighbour would follow an axis even if the front is oblique. The
// derivative of the upwind equation propagates fractions instead: a cell's are the weighted mean of
// its earlier neighbours' fractions, with weights (T - T_neighbour) / spacing^2.
struct Shares {
  std::int32_t most = kUnknown;
  std::int32_t second = kNone;
  double part = 1.0;  // of `most`
};

struct Upwind {
  Index cell;
  double weight;
};

struct UpwindSet {
  std::array<Upwind, 3> items;
  int count = 0;
};

UpwindSet upwind_of(const Grid& grid, const double* arrival, Index cell) {
  const auto strides = grid.strides();
  UpwindSet result{};
  for (int axis = 0; axis < 3; ++axis) {
    const Index at = cell / strides[axis] % grid.shape[axis];
    Index earliest = cell;
    if (at > 0 && arrival[cell - strides[axis]] < arrival[earliest])
      earliest = cell - strides[axis];
    if (at + 1 < grid.shape[axis] && arrival[cell + strides[axis]] < arrival[earliest])
      earliest = cell + strides[axis];
    if (earliest == cell) continue;
    const double spacing = grid.spacing[axis];
    const double weight = (arrival[cell] - arrival[earliest]) / (spacing * spacing);
    result.items[result.count++] = {earliest, weight};
  }
  return result;
}

Shares mean(const UpwindSet& upwind, const std::vector<Shares>& shares) {
  struct Sum {
    std::int32_t source;
    double value;
  };
  std::array<Sum, 6> sums{};
  int count = 0;
  const auto add = [&](std::int32_t source, double value) {
    int n = 0;
    while (n < count && sums[n].source != source) ++n;
    if (n == count) sums[count++] = {source, 0.0};
    sums[n].value += value;
  };
  for (int n = 0; n < upwind.count; ++n) {
    const Shares& from = shares[upwind.items[n].cell];
    add(from.most, upwind.items[n].weight * from.part);
    if (from.part < 1.0) add(from.second, upwind.items[n].weight * (1.0 - from.part));
  }
  const auto more = [](const Sum& x, const Sum& y) {
    return x.value > y.value || (x.value == y.value && x.source < y.source);
  };
  Sum most{kNone, -1.0}, second = most;
  for (int n = 0; n < count; ++n) {
    if (more(sums[n], most)) {
      second = most;
      most = sums[n];
    } else if (more(sums[n], second)) {
      second = sums[n];
    }
  }
  if (!(second.value > 0.0)) return {most.source, kNone, 1.0};
  return {most.source, second.source, most.value / (most.value + second.value)};
}

}  // namespace

std::vector<std::int32_t> nearest_sources(const Grid& grid, const double* arrival,
                                          const std::vector<Index>& sources) {
  const Index size = grid.size();
  std::vector<Shares> shares(static_cast<std::size_t>(size));
  for (std::size_t n = sources.size(); n-- > 0;)
    shares[sources[n]] = {static_cast<std::int32_t>(n), kNone, 1.0};

  std::vector<Index> waiting;  // each for earlier cells, above it
  for (Index first = 0; first < size; ++first) {
    if (arrival[first] == kInfinity) shares[first] = {kNone, kNone, 1.0};
    waiting.push_back(first);
    for (unsigned turn = 0; !waiting.empty(); ++turn) {
      check_interrupt(turn);
      const Index cell = waiting.back();
      const std::size_t before = waiting.size();
      if (shares[cell].most == kUnknown) {
        const UpwindSet upwind = upwind_of(grid, arrival, cell);
        for (int n = 0; n < upwind.count; ++n)
          if (shares[upwind.items[n].cell].most == kUnknown)
            waiting.push_back(upwind.items[n].cell);
        if (waiting.size() > before) continue;
        shares[cell] = mean(upwind, shares);
      }
      waiting.pop_back();
    }
  }
  std::vector<std::int32_t> result(shares.size());
  std::transform(shares.begin(), shares.end(), result.begin(),
                 [](const Shares& of) { return of.most; });
  return result;
}

}  // namespace leadthrough
