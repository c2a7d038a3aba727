#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "leadthrough/field/blocks.hpp"

namespace leadthrough {

// A body, with the box around it that is parallel to the grid's axes.
struct Obstacle {
  std::function<double(const Point&)> distance;  // of a point; negative inside
  Point middle;
  Point half;  // edges of the box
};

// The cells of a grid whose centres lie in an obstacle or within a margin of one.
class Walls {
 public:
  // cells: blocks of one cell each. margin: in the grid's unit.
  Walls(const Blocks& cells, double margin, std::vector<Obstacle> obstacles);

  // One flag per cell: 1 in walls, else 0.
  std::vector<std::uint8_t> hold(const std::vector<Index>& cells) const;

  // Distances of ascending cells to the nearest wall, centre to centre, at most `most`; 0 in walls.
  std::vector<double> distances(const std::vector<Index>& cells, double most) const;

  // Upper bounds of `distances` over the cells of blocks; 0 where all are walls.
  std::vector<double> farthest(const Blocks& blocks, const std::vector<Index>& numbers,
                               double most) const;

  // Lower bounds of `distances` over the cells of blocks, which may be negative.
  std::vector<double> nearest(const Blocks& blocks, const std::vector<Index>& numbers,
                              double most) const;

 private:
  double to_obstacles(const Point& point, double most) const;
  std::vector<double> to_obstacles(const Blocks& blocks, const std::vector<Index>& numbers,
                                   double most) const;
  std::vector<double> to_walls(const std::vector<Index>& cells, double most) const;

  Blocks cells_;
  double margin_;
  std::vector<Obstacle> obstacles_;
};

}  // namespace leadthrough
