#pragma once

// Balls that together contain a convex body: quick lower bounds of its distances.

#include <Eigen/Core>
#include <vector>

#include "leadthrough/collision/cores.hpp"

namespace leadthrough {

struct Ball {
  Eigen::Vector3d centre;
  double radius;  // m
};

// One ball around the whole body, and smaller ones of which every point of the body is in at least
// one; in the body's frame.
struct BallCover {
  Ball whole;
  std::vector<Ball> parts;
};
BallCover ball_cover(const Convex& body);

}  // namespace leadthrough
