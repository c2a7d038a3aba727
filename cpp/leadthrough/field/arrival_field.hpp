#pragma once

// A field of arrival times that is repaired as speeds change: obstacles appear, move and vanish.

#include <array>
#include <memory>
#include <vector>

#include "leadthrough/field/eikonal.hpp"
#include "leadthrough/field/grid.hpp"

namespace leadthrough {

struct Region {  // `shape` cells along each axis, from `low` on
  std::array<Index, 3> low;
  std::array<Index, 3> shape;
};

enum class UpdateKind { kNone, kRepair, kFullMarch };

struct Update {
  UpdateKind kind;
  Index invalidated;  // cells whose time depended on a speed that fell
};

// Times of first order, as `march_first_order` gives them. For one thread at a time: calls of
// several need a lock.
template <typename Real>
class ArrivalField {
 public:
  virtual ~ArrivalField() = default;

  // Replaces the speeds of a region, given in C order, and repairs the times. Cells that depend on
  // a slowed cell are invalidated, cells that a faster cell reaches earlier are improved; both are
  // marched again from the cells around them, or the whole field is if that is cheaper.
  virtual Update update(const Region& region, const Real* speed) = 0;
  virtual std::vector<Real> times() = 0;
};

// Real is float or double.
template <typename Real>
std::unique_ptr<ArrivalField<Real>> make_arrival_field(const Grid& grid, const Real* speed,
                                                       const std::vector<Source>& sources);

}  // namespace leadthrough
