#pragma once

#include <cstdint>
#include <vector>

#include "leadthrough/field/cell_set.hpp"

namespace leadthrough {

// Meaning of cells outside the set.
enum class Outside { kUnknown, kTarget };

// Distance from every cell of a set to the nearest target, centre to centre, infinite if there is
// none: targets are the cells whose `mask` is not 0 and, if so, those outside the set. With unknown
// cells outside it holds for targets so near that the set holds all cells about them up to there.
std::vector<double> distance_transform(const CellSet& set, const std::uint8_t* mask,
                                       Outside outside);

}  // namespace leadthrough
