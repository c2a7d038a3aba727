// Penetration depth of two cores: a polytope inside their Minkowski difference grows at its face
// nearest to the origin until that face lies on the difference's own surface (van den Bergen 2001).
// Faces may lie on either side of the origin, so that touching cores are no special case.

#include <algorithm>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/collision/minkowski.hpp"

namespace leadthrough::minkowski {

namespace {

constexpr double kDepthTolerance = 1e-8;  // m, between the polytope and the surface beyond
// Curved bodies need some dozens for the tolerance; the bound keeps the work on the stack.
constexpr int kMaxVertices = 160;
constexpr int kMaxEdges = 3 * kMaxVertices;
// A face is visible from a point that lies beyond it by at least this, m.
constexpr double kVisible = 1e-13;

struct Face {
  std::array<int, 3> corners;
  Vector3d normal;  // unit, outwards
  double offset;    // of its plane from the origin
};

class Polytope {
 public:
  explicit Polytope(const Difference& difference) : difference_(difference) { start(); }

  Depth shrink_to_origin() {
    double least = kInfinity;
    Vector3d normal = Vector3d::UnitX();
    while (true) {
      const int i = nearest_face();
      const Vector3d direction = face(i).normal;
      const Vertex beyond = difference_.farthest(direction);
      const double depth = direction.dot(beyond.point);
      if (depth < least) {
        least = depth;
        normal = direction;
      }
      if (depth - face(i).offset <= kDepthTolerance || !grow(beyond)) break;
    }
    return witness(least, normal);
  }

 private:
  const Vector3d& point(int i) const { return vertices_[static_cast<std::size_t>(i)].point; }

  int add(const Vertex& vertex) {
    vertices_[static_cast<std::size_t>(count_)] = vertex;
    return count_++;
  }

  // A tetrahedron that is as wide as the difference in each new direction.
  void start() {
    add(difference_.farthest(Vector3d::UnitX()));
    add(farther_of(Vector3d::UnitX(), point(0)));
    const Vector3d edge = (point(1) - point(0)).normalized();
    Eigen::Index thin = 0;
    edge.cwiseAbs().minCoeff(&thin);
    const Vector3d across = edge.cross(Vector3d::Unit(thin)).normalized();
    add(farther_of(across, point(0)));
    const Vector3d normal = edge.cross(point(2) - point(0)).normalized();
    add(farther_of(normal, point(0)));
    for (const auto& corners : {std::array<int, 3>{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}})
      add_face(corners);
    middle_ = 0.25 * (point(0) + point(1) + point(2) + point(3));
    for (int i = 0; i < faces_; ++i) turn_outwards(face(i));
  }

  // Of the two ends of the difference along a line, the one farther from a point.
  Vertex farther_of(const Vector3d& along, const Vector3d& from) const {
    const Vertex ahead = difference_.farthest(along);
    const Vertex behind = difference_.farthest(-along);
    return along.dot(ahead.point - from) >= along.dot(from - behind.point) ? ahead : behind;
  }

  Face& face(int i) { return faces_list_[static_cast<std::size_t>(i)]; }

  bool add_face(const std::array<int, 3>& corners) {
    if (faces_ == static_cast<int>(faces_list_.size())) return false;
    const Vector3d& p = point(corners[0]);
    const Vector3d across = (point(corners[1]) - p).cross(point(corners[2]) - p);
    const double area = across.norm();
    // A sliver has no defined side; it stays for its edges and is never selected.
    const bool sliver = !(area > 0.0);
    const Vector3d normal = sliver ? Vector3d::Zero() : Vector3d(across / area);
    const double offset = sliver ? kInfinity : normal.dot(p);
    face(faces_++) = {corners, normal, offset};
    return true;
  }

  void turn_outwards(Face& side) const {
    if (side.normal.dot(point(side.corners[0]) - middle_) >= 0.0) return;
    std::swap(side.corners[1], side.corners[2]);
    side.normal = -side.normal;
    side.offset = -side.offset;
  }

  int nearest_face() {
    int nearest = 0;
    for (int i = 1; i < faces_; ++i)
      if (face(i).offset < face(nearest).offset) nearest = i;
    return nearest;
  }

  // Replaces the faces visible from a vertex; false without room or progress.
  bool grow(const Vertex& vertex) {
    if (count_ == kMaxVertices) return false;
    edges_ = 0;
    for (int i = 0; i < faces_;) {
      if (face(i).normal.dot(vertex.point) - face(i).offset <= kVisible) {
        ++i;
        continue;
      }
      const auto corners = face(i).corners;
      face(i) = face(--faces_);
      for (std::size_t c = 0; c < 3; ++c)
        if (!add_edge(corners[c], corners[(c + 1) % 3])) return false;
    }
    if (edges_ == 0) return false;
    const int tip = add(vertex);
    for (int i = 0; i < edges_; ++i) {
      const auto& edge = edges_list_[static_cast<std::size_t>(i)];
      if (!add_face({edge[0], edge[1], tip})) return false;
    }
    return true;
  }

  // The two directions of an edge between two removed faces cancel each other.
  bool add_edge(int from, int to) {
    for (int i = 0; i < edges_; ++i) {
      auto& edge = edges_list_[static_cast<std::size_t>(i)];
      if (edge[0] != to || edge[1] != from) continue;
      edge = edges_list_[static_cast<std::size_t>(--edges_)];
      return true;
    }
    if (edges_ == kMaxEdges) return false;
    edges_list_[static_cast<std::size_t>(edges_++)] = {from, to};
    return true;
  }

  // The surface may be flat there and made of several faces: the origin's foot is on one of them.
  Depth witness(double depth, const Vector3d& normal) {
    const double far = face(nearest_face()).offset + kDepthTolerance;
    const Vector3d foot = depth * normal;
    Depth found{depth, normal, Vector3d::Zero(), Vector3d::Zero()};
    double least = kInfinity;
    for (int i = 0; i < faces_; ++i) {
      if (face(i).offset > far) continue;
      Simplex triangle;
      for (const int corner : face(i).corners)
        triangle.add(vertices_[static_cast<std::size_t>(corner)]);
      const Weights weights = nearest_on_triangle(triangle, 0, 1, 2);
      const double off = (blend(triangle, weights, &Vertex::point) - foot).squaredNorm();
      if (off >= least) continue;
      least = off;
      found.on_a = blend(triangle, weights, &Vertex::on_a);
      found.on_b = blend(triangle, weights, &Vertex::on_b);
    }
    return found;
  }

  const Difference& difference_;
  std::array<Vertex, kMaxVertices> vertices_;
  std::array<Face, 2 * kMaxVertices> faces_list_;
  std::array<std::array<int, 2>, kMaxEdges> edges_list_;
  Vector3d middle_;
  int count_ = 0;
  int faces_ = 0;
  int edges_ = 0;
};

}  // namespace

Depth penetration(const Difference& difference) { return Polytope(difference).shrink_to_origin(); }

}  // namespace leadthrough::minkowski
