#pragma once

// The quickest path through a map, marched only where it can lie.
//
// The map is searched in blocks of cells, from coarse to fine. In each block the wave runs as fast
// as in the fastest of its cells, so its time is never later than in the map itself: the time of a
// path from start to goal through a block is a lower bound. Only blocks whose bound is at most a
// limit are refined, down to single cells. If the path takes longer than the limit, the limit rises
// to the path's time and the search restarts: in the end no path outside the band can be quicker.
// The cost thus grows with the path, not with the map.

#include <vector>

#include "leadthrough/field/speed_map.hpp"

namespace leadthrough {

enum class QuickestStatus { kFound, kStartInWall, kGoalInWall, kSeparated };

struct Quickest {
  QuickestStatus status;
  std::vector<Point> path;  // from start to goal if it is found
};

// The same path as from a march through the whole map. One of the ends may lie outside the grid:
// the path is straight between it and the first cell.
Quickest quickest_path(const SpeedMap& map, const Point& start, const Point& goal);

}  // namespace leadthrough
