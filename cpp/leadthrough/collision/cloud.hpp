#pragma once

// Balls of one radius around many points, such as a depth camera's, in a tree of bounding balls. A
// query visits only the branches whose ball is near enough to the body.

#include <Eigen/Core>
#include <vector>

#include "leadthrough/base/matrix.hpp"
#include "leadthrough/collision/convex_distance.hpp"

namespace leadthrough {

class Cloud {
 public:
  static constexpr int kMaxPoints = 1 << 24;

  // points: at least one, finite, in any frame; radius: m, > 0.
  Cloud(const Rows3Ref& points, double radius);

  double radius() const { return radius_; }
  // The middle of the box around the points, in their frame; the origin of all other quantities.
  const Eigen::Vector3d& middle() const { return middle_; }
  // Of a ball about the middle that holds all balls, m.
  double bounding_radius() const { return nodes_.front().radius + radius_; }
  // Extent of the balls from the middle along a unit vector, m.
  double reach(const Eigen::Vector3d& along) const;

  const Eigen::Vector3d& nearest_to(const Eigen::Vector3d& point) const;

  // As for convex bodies, for the ball that the body is nearest to or deepest in; a distance of at
  // least `cutoff` is returned as `cutoff`, without points and normal. radius: of a bounding ball
  // about the body's origin, m.
  Separation separation(const Transform& T_base_cloud, const Convex& body,
                        const Transform& T_base_body, double radius, double cutoff) const;
  bool apart(const Transform& T_base_cloud, const Convex& body, const Transform& T_base_body,
             double radius, double least) const;

 private:
  // Without points of its own it has two branches: the next node and the node `second`.
  struct Node {
    Eigen::Vector3d centre;
    double radius;  // of a ball that holds the points
    int first, count, second;
  };

  void split(int first, int end, std::vector<int>& order, const Rows3Ref& points);
  template <typename Probe, typename Visit>
  bool search(const Probe& probe, const double& least, const Visit& visit) const;
  template <typename Probe>
  const Eigen::Vector3d* nearest(const Probe& probe, double least) const;

  double radius_;
  Eigen::Vector3d middle_;
  std::vector<Eigen::Vector3d> points_;  // in the order of the leaves
  std::vector<Node> nodes_;
};

}  // namespace leadthrough
