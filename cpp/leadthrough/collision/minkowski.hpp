#pragma once

// The Minkowski difference of two cores, given by its support points.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "leadthrough/collision/convex_distance.hpp"

namespace leadthrough::minkowski {

using Eigen::Vector3d;

// A point of the difference, and the points of a and b that it is the difference of.
struct Vertex {
  Vector3d point;
  Vector3d on_a, on_b;
};

// a minus b, in the frame of a.
struct Difference {
  const Convex& a;
  const Convex& b;
  Eigen::Matrix3d R_a_b;
  Vector3d p_a_b;

  [[gnu::flatten]] Vertex farthest(const Vector3d& along) const {
    const Vector3d on_a = support(a, along);
    const Vector3d on_b = R_a_b * support(b, -(R_a_b.transpose() * along)) + p_a_b;
    return {on_a - on_b, on_a, on_b};
  }
};

using Weights = std::array<double, 4>;

// At most four vertices.
struct Simplex {
  std::array<Vertex, 4> vertices;
  Weights weights{};  // of the point nearest to the origin
  int size = 0;

  void add(const Vertex& vertex) { vertices[static_cast<std::size_t>(size++)] = vertex; }
  bool has(const Vector3d& point) const;
  // Computes the weights, drops the vertices of weight 0 and returns the nearest point.
  Vector3d reduce();
};

// The parts of a simplex; corners are indices of its vertices.
Weights nearest_on_triangle(const Simplex& simplex, int i, int j, int k);

// The sum of the vertices' points of one of the two bodies, or of the difference.
inline Vector3d blend(const Simplex& simplex, const Weights& weights, Vector3d Vertex::* which) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(simplex.size); ++i)
    sum += weights[i] * (simplex.vertices[i].*which);
  return sum;
}

// The shallowest direction of a difference with a volume: the points of a beyond it are the least
// deep in b. depth: below zero where the origin is outside.
struct Depth {
  double depth;
  Vector3d normal;  // unit, from a into b
  Vector3d on_a, on_b;
};
Depth penetration(const Difference& difference);

}  // namespace leadthrough::minkowski
