#pragma once

// Collision-free joint motion of the whole arm along a path of the tip, between samples as well:
// the ladder graph selects the branch of postures, the refinement smooths it and increases its
// clearance, the check certifies it.

#include "leadthrough/collision/check.hpp"
#include "leadthrough/path/ladder.hpp"

namespace leadthrough::path {

struct Margins {
  double obstacles = 0.0;  // m
  double itself = 0.0;
};

struct ClearPath {
  Rows q;                          // one row per sample; none if no path was found
  std::optional<JointArray> last;  // the configuration at the last layer reached
  DeadEnd dead_end;
  // The closest pair, if a path was found but is not certified.
  std::optional<ClosestPair> touch;
};

// After a failed search the next is finer and takes three times as long.
constexpr int kMaxAttempts = 3;

// Bodies are numbered as in `against(model, obstacles)`.
ClearPath find_clear_path(const CollisionModel& model, const PlacedShapes& obstacles,
                          const TipPath& path, const RowsRef& postures,
                          const std::optional<JointArray>& start, const Margins& margins,
                          const IkTolerance& tolerance, int max_attempts = kMaxAttempts);

}  // namespace leadthrough::path
