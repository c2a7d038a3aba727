#pragma once

// Waves from both ends of a path through blocks: lower bounds of path times through each block.

#include <optional>
#include <vector>

#include "leadthrough/field/blocks.hpp"
#include "leadthrough/field/eikonal.hpp"

namespace leadthrough {

// Entry through which an outside wave first reaches an endpoint of a path.
struct PathEnd {
  std::vector<Source> entries;
  bool is_outside;  // beyond the blocks; otherwise there is exactly one entry
};

// Entry through which an outside wave first reaches an endpoint, and its time; empty if
// unreachable.
std::optional<Source> first_of(const PathEnd& end, const CellSet& cells,
                               const std::vector<double>& times);

struct Waves {
  std::vector<double> through;  // least times from end to end through each block of the set
  double arrival;               // the later one of both waves'; infinite if there is no path
  bool is_open;                 // a path may exist beyond these blocks
};

// speed: of each block, above 0 at ends that lie in one. reach: as of `Blocks`.
Waves waves_between(const CellSet& blocks, const double* speed, const PathEnd& start,
                    const PathEnd& goal, double reach);

}  // namespace leadthrough
