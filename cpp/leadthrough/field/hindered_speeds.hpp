#pragma once

// Speed maps with obstacles: obstacles are walls, cells near them are slower.

#include <memory>
#include <vector>

#include "leadthrough/field/speed_map.hpp"
#include "leadthrough/field/walls.hpp"

namespace leadthrough {

// Product of the map without obstacles and the obstacles' map, which grows from 0 inside them to 1
// at distance `reach`.
class HinderedSpeeds : public SpeedMap {
 public:
  HinderedSpeeds(std::shared_ptr<const SpeedMap> free, Walls walls, double reach);
  std::vector<double> at(const std::vector<Index>& cells) const override;
  std::vector<double> fastest(const Blocks& blocks,
                              const std::vector<Index>& numbers) const override;

 private:
  std::shared_ptr<const SpeedMap> free_;
  Walls walls_;
  double reach_;
};

// Minimum of both maps where the obstacles' map is below a saturation (Prados et al. 2023, eq. 7).
class SaturatedSpeeds : public SpeedMap {
 public:
  SaturatedSpeeds(std::shared_ptr<const SpeedMap> free, Walls walls, double reach,
                  double saturation);
  std::vector<double> at(const std::vector<Index>& cells) const override;
  std::vector<double> fastest(const Blocks& blocks,
                              const std::vector<Index>& numbers) const override;

 private:
  std::vector<double> lowered(std::vector<double> free, const std::vector<double>& beside) const;

  std::shared_ptr<const SpeedMap> free_;
  Walls walls_;
  double reach_;
  double saturation_;
};

// Product of both maps, with a detour tube of two bands' width around obstacles in a tube.
class PassableSpeeds : public SpeedMap {
 public:
  // band: distance over which the speed grows from 0 at an obstacle to its free value.
  // reach: of the detours, from an obstacle's cells in a tube.
  PassableSpeeds(std::shared_ptr<const FreeSpeeds> free, Walls walls, double band, double reach);
  std::vector<double> at(const std::vector<Index>& cells) const override;
  std::vector<double> fastest(const Blocks& blocks,
                              const std::vector<Index>& numbers) const override;

 private:
  // True for points within the reach, plus `room`, of walls in a tube.
  std::vector<bool> are_near_struck(const std::vector<Point>& points, double room) const;

  std::shared_ptr<const FreeSpeeds> free_;
  Walls walls_;
  double around_;  // two bands
  double reach_;
  std::vector<Point> struck_;  // centres of the wall cells in tubes
};

}  // namespace leadthrough
