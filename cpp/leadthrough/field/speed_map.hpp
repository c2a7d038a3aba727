#pragma once

// Speeds of a map's cells, computed on request and independent of the map's size, with upper bounds
// over blocks of cells.
// Source: Prados et al. 2023, Appl. Sci. 13:2028, Algorithm 1.

#include <vector>

#include "leadthrough/field/blocks.hpp"

namespace leadthrough {

// Radii are often whole numbers of cells: rounding must not decide which cells belong.
constexpr double kRadiusRounding = 1e-9;

class SpeedMap {
 public:
  // outside: the speed beyond the grid, which has no walls; 0 bars waves from leaving the grid.
  SpeedMap(const Blocks& cells, double outside) : cells_(cells), outside_(outside) {}
  virtual ~SpeedMap() = default;
  SpeedMap(const SpeedMap&) = delete;
  SpeedMap& operator=(const SpeedMap&) = delete;

  const Blocks& cells() const { return cells_; }
  double outside() const { return outside_; }

  // Of cells, which are ascending; 0 in walls.
  virtual std::vector<double> at(const std::vector<Index>& cells) const = 0;

  // Upper bounds of the speeds of the cells of blocks; 0 where all are walls.
  virtual std::vector<double> fastest(const Blocks& blocks,
                                      const std::vector<Index>& numbers) const = 0;

 private:
  Blocks cells_;
  double outside_;
};

// Given speeds, one per cell: finite and not negative, or std::invalid_argument is thrown.
class GivenSpeeds : public SpeedMap {
 public:
  GivenSpeeds(const Blocks& cells, double outside, std::vector<double> speeds);
  std::vector<double> at(const std::vector<Index>& cells) const override;
  std::vector<double> fastest(const Blocks& blocks,
                              const std::vector<Index>& numbers) const override;

 private:
  double fastest_in(const Blocks& blocks, Index number) const;

  std::vector<double> speeds_;
};

// Speeds without obstacles; above the saturation only in tubes about paths.
class FreeSpeeds : public SpeedMap {
 public:
  FreeSpeeds(const Blocks& cells, double saturation) : SpeedMap(cells, saturation) {}

  double saturation() const { return outside(); }

  // The cells in tubes, ascending.
  virtual std::vector<Index> in_tube() const = 0;
};

// 1 deepest in the tube about the cells that paths cross, falling to the saturation at its border.
class ExperienceSpeeds : public FreeSpeeds {
 public:
  // paths: in the grid, finely sampled. radius: of the tube, in the grid's unit.
  ExperienceSpeeds(const Blocks& cells, double saturation,
                   const std::vector<std::vector<Point>>& paths, double radius);
  std::vector<double> at(const std::vector<Index>& cells) const override;
  std::vector<double> fastest(const Blocks& blocks,
                              const std::vector<Index>& numbers) const override;
  std::vector<Index> in_tube() const override { return levels_.front().numbers; }

 private:
  // Blocks that hold cells of the tube, ascending, and the largest speed in each.
  struct Level {
    std::vector<Index> numbers;
    std::vector<double> speeds;
  };

  Level coarser(const Level& fine, const Blocks& fine_blocks, const Blocks& blocks) const;
  std::vector<double> looked_up(const Level& level, const std::vector<Index>& numbers) const;

  std::vector<Level> levels_;
};

// A path with a tube of high speed about it.
struct Tube {
  std::vector<Point> path;  // finely sampled
  double weight;            // in [0, 1], of the speed on the path
};

// Speeds that fall over a radius from each tube's weight, 1 being the speed limit, to the
// saturation.
class TubeSpeeds : public FreeSpeeds {
 public:
  TubeSpeeds(const Blocks& cells, double saturation, std::vector<Tube> tubes, double radius);
  std::vector<double> at(const std::vector<Index>& cells) const override;
  std::vector<double> fastest(const Blocks& blocks,
                              const std::vector<Index>& numbers) const override;
  std::vector<Index> in_tube() const override;

 private:
  std::vector<Tube> tubes_;
  double radius_;
};

}  // namespace leadthrough
