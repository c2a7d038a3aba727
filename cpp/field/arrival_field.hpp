#pragma once

// A field of arrival times that is kept while speeds change: obstacles appear, move and vanish.

#include <array>
#include <memory>
#include <vector>

#include "field/eikonal.hpp"
#include "field/grid.hpp"

namespace leadthrough {

struct Region {  // cells from `low` on, as many along each axis as `shape` says
  std::array<Index, 3> low;
  std::array<Index, 3> shape;
};

enum class UpdateKind { kNone, kRepair, kFullMarch };

struct Update {
  UpdateKind kind;
  Index invalidated;  // cells whose time rested on a speed that fell
};

// Times of first order, as `march_first_order` gives them.
template <typename Real>
class ArrivalField {
 public:
  virtual ~ArrivalField() = default;

  // Replaces the speeds of a region, given in C order, and repairs the times. Cells that rested on
  // a cell now slower are invalidated, those of a front through a cell now faster improved; both
  // are marched anew from what is around them, or everything is, where that is cheaper.
  virtual Update update(const Region& region, const Real* speed) = 0;
  virtual std::vector<Real> times() const = 0;
};

// Real is float or double.
template <typename Real>
std::unique_ptr<ArrivalField<Real>> make_arrival_field(const Grid& grid, const Real* speed,
                                                       const std::vector<Source>& sources);

}  // namespace leadthrough
