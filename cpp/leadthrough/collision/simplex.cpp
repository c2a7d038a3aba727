// The point of a simplex nearest to the origin, by signed volumes (Montanari, Petrinic and Barbieri
// 2017): if the origin's projection lies outside, only the faces that it lies beyond are tested.

#include "leadthrough/base/constants.hpp"
#include "leadthrough/collision/minkowski.hpp"

namespace leadthrough::minkowski {

namespace {

// Sines of angles below this are rounding: the triangle or tetrahedron is flat.
constexpr double kFlat = 1e-12;

const Vector3d& point(const Simplex& simplex, int i) {
  return simplex.vertices[static_cast<std::size_t>(i)].point;
}

double& at(Weights& weights, int i) { return weights[static_cast<std::size_t>(i)]; }

double squared_length(const Simplex& simplex, const Weights& weights) {
  return blend(simplex, weights, &Vertex::point).squaredNorm();
}

void keep_nearer(const Simplex& simplex, const Weights& candidate, Weights& best, double& least) {
  const double length = squared_length(simplex, candidate);
  if (length >= least) return;
  least = length;
  best = candidate;
}

Weights nearest_on_edge(const Simplex& simplex, int i, int j) {
  const Vector3d& start = point(simplex, i);
  const Vector3d edge = point(simplex, j) - start;
  const double length = edge.squaredNorm();
  const double share = length > 0.0 ? std::min(std::max(-start.dot(edge) / length, 0.0), 1.0) : 0.0;
  Weights weights{};
  at(weights, i) = 1.0 - share;
  at(weights, j) = share;
  return weights;
}

Weights nearest_on_tetrahedron(const Simplex& simplex) {
  constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};  // i: without vertex i
  const Vector3d& p0 = point(simplex, 0);
  const Vector3d e1 = point(simplex, 1) - p0;
  const Vector3d e2 = point(simplex, 2) - p0;
  const Vector3d e3 = point(simplex, 3) - p0;
  const double volume = e1.dot(e2.cross(e3));
  const bool flat = std::abs(volume) <= kFlat * e1.norm() * e2.norm() * e3.norm();
  Weights volumes{};
  bool inside = !flat;
  for (int i = 0; i < 4; ++i) {
    const auto& face = kFaces[i];
    const Vector3d& a = point(simplex, face[0]);
    at(volumes, i) = a.dot(point(simplex, face[1]).cross(point(simplex, face[2])));
    inside = inside && at(volumes, i) * volume > 0.0;
  }
  if (inside) {
    for (double& part : volumes) part /= volume;
    return volumes;
  }
  Weights best{};
  double least = kInfinity;
  for (int i = 0; i < 4; ++i) {
    if (!flat && at(volumes, i) * volume > 0.0) continue;
    const auto& face = kFaces[i];
    keep_nearer(simplex, nearest_on_triangle(simplex, face[0], face[1], face[2]), best, least);
  }
  return best;
}

}  // namespace

bool Simplex::has(const Vector3d& candidate) const {
  for (int i = 0; i < size; ++i)
    if (point(*this, i) == candidate) return true;
  return false;
}

Weights nearest_on_triangle(const Simplex& simplex, int i, int j, int k) {
  const int corners[3] = {i, j, k};
  const Vector3d& p = point(simplex, i);
  const Vector3d e1 = point(simplex, j) - p;
  const Vector3d e2 = point(simplex, k) - p;
  const Vector3d normal = e1.cross(e2);
  const double square = normal.squaredNorm();
  const bool flat = square <= kFlat * kFlat * e1.squaredNorm() * e2.squaredNorm();
  // Areas in the coordinate plane in which the triangle is largest.
  int x = 0;
  if (std::abs(normal.y()) > std::abs(normal[x])) x = 1;
  if (std::abs(normal.z()) > std::abs(normal[x])) x = 2;
  const int u = (x + 1) % 3;
  const int v = (x + 2) % 3;
  const Vector3d foot = flat ? Vector3d::Zero() : Vector3d(normal * (normal.dot(p) / square));
  double areas[3];
  bool inside = !flat;
  for (int c = 0; c < 3; ++c) {
    const Vector3d a = point(simplex, corners[(c + 1) % 3]) - foot;
    const Vector3d b = point(simplex, corners[(c + 2) % 3]) - foot;
    areas[c] = a[u] * b[v] - a[v] * b[u];
    inside = inside && areas[c] * normal[x] > 0.0;
  }
  Weights best{};
  if (inside) {
    for (int c = 0; c < 3; ++c) at(best, corners[c]) = areas[c] / normal[x];
    return best;
  }
  double least = kInfinity;
  for (int c = 0; c < 3; ++c) {
    if (!flat && areas[c] * normal[x] > 0.0) continue;
    const int from = corners[(c + 1) % 3];
    const int to = corners[(c + 2) % 3];
    keep_nearer(simplex, nearest_on_edge(simplex, from, to), best, least);
  }
  return best;
}

Vector3d Simplex::reduce() {
  Weights found{1.0};
  if (size == 2) found = nearest_on_edge(*this, 0, 1);
  if (size == 3) found = nearest_on_triangle(*this, 0, 1, 2);
  if (size == 4) found = nearest_on_tetrahedron(*this);
  int kept = 0;
  for (int i = 0; i < size; ++i) {
    if (at(found, i) == 0.0) continue;
    vertices[static_cast<std::size_t>(kept)] = vertices[static_cast<std::size_t>(i)];
    at(weights, kept++) = at(found, i);
  }
  size = kept;
  return blend(*this, weights, &Vertex::point);
}

}  // namespace leadthrough::minkowski
