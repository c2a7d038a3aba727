#pragma once

// Speed maps with obstacles: walls where they are, and slower cells beside them.

#include <memory>
#include <vector>

#include "field/speed_map.hpp"
#include "field/walls.hpp"

namespace leadthrough {

// A map without obstacles times the obstacles' own, which grows from 0 in them to 1 at `reach`.
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

// The smaller of both maps where the obstacles' own one is below a saturation (Prados et al. 2023,
// eq. 7).
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

// The product of both maps, where a tube of two bands' width leads round what stands in a tube.
class PassableSpeeds : public SpeedMap {
 public:
  // band: over which the speed grows from 0 at an obstacle to its own value.
  // reach: of the ways round, from where an obstacle stands in a tube.
  PassableSpeeds(std::shared_ptr<const FreeSpeeds> free, Walls walls, double band, double reach);
  std::vector<double> at(const std::vector<Index>& cells) const override;
  std::vector<double> fastest(const Blocks& blocks,
                              const std::vector<Index>& numbers) const override;

 private:
  // Whether points lie within the reach, and some room, of walls in a tube.
  std::vector<bool> are_near_struck(const std::vector<Point>& points, double room) const;

  std::shared_ptr<const FreeSpeeds> free_;
  Walls walls_;
  double around_;  // two bands
  double reach_;
  std::vector<Point> struck_;  // centres of the walls in tubes
};

}  // namespace leadthrough
