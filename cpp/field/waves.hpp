#pragma once

// Waves from both ends of a way through blocks, which tell what each block is good for.

#include <optional>
#include <vector>

#include "field/blocks.hpp"
#include "field/eikonal.hpp"

namespace leadthrough {

// Entry through which an outside wave first reaches an endpoint of a path.
struct WayEnd {
  std::vector<Source> entries;
  bool is_outside;  // beyond the blocks; else there is one entry
};

// By which of its entries a wave from elsewhere comes first to an end, and when; none if it does
// not.
std::optional<Source> first_of(const WayEnd& end, const CellSet& cells,
                               const std::vector<double>& times);

struct Waves {
  std::vector<double> through;  // least times from end to end through each block of the set
  double arrival;               // the later one of both waves'; infinite if there is no way
  bool is_open;                 // whether there may be one beyond these blocks
};

// speed: of each block, above 0 at ends that lie in one. reach: as of `Blocks`.
Waves waves_between(const CellSet& blocks, const double* speed, const WayEnd& start,
                    const WayEnd& goal, double reach);

}  // namespace leadthrough
