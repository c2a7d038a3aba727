#include "leadthrough/collision/cloud.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <type_traits>
#include <utility>
#include <variant>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/collision/scene.hpp"

namespace leadthrough {

namespace {

using Eigen::Vector3d;

constexpr int kLeaf = 8;  // maximum number of points of a leaf
constexpr std::size_t kPlanes = 8;
constexpr int kDepth = 64;  // more halvings than any number of points needs

Transform unturned(const Vector3d& position) { return {Eigen::Matrix3d::Identity(), position}; }

// A body among points in their frame. radius: of a ball about its origin that holds it.
template <typename OwnCore>
class Probe {
 public:
  Probe(const Convex& body, const OwnCore& core, const Transform& pose, double radius)
      : body_(body), core_(core), pose_(pose), back_(pose.rotation.transpose()), radius_(radius) {}

  double square_to(const Vector3d& point) const { return (point - pose_.position).squaredNorm(); }

  // True if the body's distance from a point is at least `least`. For a hull this test is cheaper
  // than the distance, and false for points inside at any depth.
  bool keeps(const Vector3d& point, double least) const {
    if constexpr (!OwnCore::kClosedForm) {
      const double reach = least + radius_;
      if (reach <= 0.0 || square_to(point) >= reach * reach) return true;
      return beyond_a_plane(point, least) || seen_apart(point, least);
    } else {
      const cores::Offset offset = core_.offset(point - pose_.position, pose_.rotation, back_);
      const double needed = least + body_.rounding;
      if (offset.beyond <= 0.0) return offset.beyond >= needed;
      return needed <= 0.0 || offset.square >= needed * needed;
    }
  }

  double distance(const Vector3d& point) const {
    if constexpr (!OwnCore::kClosedForm) {
      return separation(sphere(0.0), unturned(point), body_, pose_).distance;
    } else {
      const cores::Offset offset = core_.offset(point - pose_.position, pose_.rotation, back_);
      return (offset.beyond > 0.0 ? std::sqrt(offset.square) : offset.beyond) - body_.rounding;
    }
  }

 private:
  // True if a stored supporting plane of the hull separates it from the point.
  bool beyond_a_plane(const Vector3d& point, double least) const {
    for (std::size_t i = 0; i < std::min(planes_, kPlanes); ++i)
      if (normals_[i].dot(point) - offsets_[i] >= least) return true;
    return false;
  }

  // The result of `apart`; its plane is stored, since nearby points may lie beyond it too.
  bool seen_apart(const Vector3d& point, double least) const {
    if (!apart(sphere(0.0), unturned(point), body_, pose_, least, normal_)) return false;
    const Vector3d touched = support(body_, -(back_ * normal_));
    const std::size_t i = planes_++ % kPlanes;
    normals_[i] = -normal_;
    offsets_[i] = normals_[i].dot(pose_.rotation * touched + pose_.position);
    return true;
  }

  const Convex& body_;
  const OwnCore& core_;
  const Transform& pose_;
  Eigen::Matrix3d back_;
  double radius_;
  // The last separating normal of a hull, and its latest separating planes with their offsets.
  mutable Vector3d normal_ = Vector3d::UnitX();
  mutable std::array<Vector3d, kPlanes> normals_;
  mutable std::array<double, kPlanes> offsets_;
  mutable std::size_t planes_ = 0;
};

// Calls work(probe) with a body in the frame of a cloud.
template <typename Work>
auto with_probe(const Convex& body, const Transform& T_cloud_body, double radius,
                const Work& work) {
  return std::visit(
      [&](const auto& core) {
        return work(Probe<std::decay_t<decltype(core)>>(body, core, T_cloud_body, radius));
      },
      body.core);
}

Transform seen_from(const Transform& T_base_cloud, const Transform& T_base_body) {
  return inverse(T_base_cloud) * T_base_body;
}

}  // namespace

Cloud::Cloud(const Rows3Ref& points, double radius)
    : radius_(radius),
      middle_(0.5 * (points.colwise().minCoeff() + points.colwise().maxCoeff()).transpose()) {
  std::vector<int> order(static_cast<std::size_t>(points.rows()));
  std::iota(order.begin(), order.end(), 0);
  points_.reserve(order.size());
  split(0, static_cast<int>(order.size()), order, points);
}

// Halves the points along the longer side of their box until few are left.
void Cloud::split(int first, int end, std::vector<int>& order, const Rows3Ref& points) {
  check_interrupt();
  const auto point = [&](int i) -> Vector3d {
    return points.row(order[static_cast<std::size_t>(i)]).transpose() - middle_;
  };
  Vector3d lower = point(first);
  Vector3d upper = lower;
  for (int i = first + 1; i < end; ++i) {
    lower = lower.cwiseMin(point(i));
    upper = upper.cwiseMax(point(i));
  }
  const Vector3d centre = 0.5 * (lower + upper);
  double square = 0.0;
  for (int i = first; i < end; ++i) square = std::max(square, (point(i) - centre).squaredNorm());
  const std::size_t own = nodes_.size();
  nodes_.push_back({centre, std::sqrt(square), first, end - first, 0});
  if (end - first <= kLeaf) {
    for (int i = first; i < end; ++i) points_.push_back(point(i));
    return;
  }
  Eigen::Index axis = 0;
  (upper - lower).maxCoeff(&axis);
  const int half = first + (end - first) / 2;
  // Ties of coordinates are ordered by index: the same cloud has the same tree.
  std::nth_element(order.begin() + first, order.begin() + half, order.begin() + end,
                   [&](int a, int b) {
                     return std::make_pair(points(a, axis), a) < std::make_pair(points(b, axis), b);
                   });
  nodes_[own].count = 0;
  split(first, half, order, points);
  nodes_[own].second = static_cast<int>(nodes_.size());
  split(half, end, order, points);
}

// Calls visit(point) for all points whose distance from the body is below `least`, which may fall
// meanwhile, and for some inside it, until a visit returns true; returns whether one did.
template <typename Probe, typename Visit>
bool Cloud::search(const Probe& probe, const double& least, const Visit& visit) const {
  std::array<int, kDepth> waiting;
  std::size_t count = 0;
  waiting[count++] = 0;
  while (count > 0) {
    const int i = waiting[--count];
    const Node& node = nodes_[static_cast<std::size_t>(i)];
    if (probe.keeps(node.centre, least + node.radius)) continue;
    for (int k = node.first; k < node.first + node.count; ++k) {
      const Vector3d& point = points_[static_cast<std::size_t>(k)];
      if (!probe.keeps(point, least) && visit(point)) return true;
    }
    if (node.count > 0) continue;
    // The nearer one is visited first.
    const double to_first = probe.square_to(nodes_[static_cast<std::size_t>(i) + 1].centre);
    const double to_second = probe.square_to(nodes_[static_cast<std::size_t>(node.second)].centre);
    waiting[count++] = to_first < to_second ? node.second : i + 1;
    waiting[count++] = to_first < to_second ? i + 1 : node.second;
  }
  return false;
}

// The point that the body is nearest to or deepest in, if nearer than `least`.
template <typename Probe>
const Vector3d* Cloud::nearest(const Probe& probe, double least) const {
  const Vector3d* nearest = nullptr;
  search(probe, least, [&](const Vector3d& found) {
    const double distance = probe.distance(found);
    if (distance >= least) return false;
    least = distance;
    nearest = &found;
    return false;
  });
  return nearest;
}

double Cloud::reach(const Vector3d& along) const {
  double most = -kInfinity;
  for (const Vector3d& point : points_) most = std::max(most, along.dot(point));
  return most + radius_;
}

const Vector3d& Cloud::nearest_to(const Vector3d& point) const {
  const cores::Point core;
  const Convex body{core};
  const Transform pose = unturned(point);
  check_argument((point.array().abs() < kTooFar).all(), "point: expected numbers below 1e100");
  return *nearest(Probe<cores::Point>(body, core, pose, 0.0), kInfinity);
}

Separation Cloud::separation(const Transform& T_base_cloud, const Convex& body,
                             const Transform& T_base_body, double radius, double cutoff) const {
  const Vector3d* found =
      with_probe(body, seen_from(T_base_cloud, T_base_body), radius,
                 [&](const auto& probe) { return nearest(probe, cutoff + radius_); });
  if (!found) return {cutoff, Vector3d::Zero(), Vector3d::Zero(), Vector3d::UnitX()};
  const Transform ball = unturned(T_base_cloud.rotation * *found + T_base_cloud.position);
  return leadthrough::separation(sphere(radius_), ball, body, T_base_body);
}

bool Cloud::apart(const Transform& T_base_cloud, const Convex& body, const Transform& T_base_body,
                  double radius, double least) const {
  const double needed = least + radius_;
  return with_probe(body, seen_from(T_base_cloud, T_base_body), radius, [&](const auto& probe) {
    return !search(probe, needed, [&](const Vector3d& found) {
      return needed > 0.0 || probe.distance(found) < needed;
    });
  });
}

}  // namespace leadthrough
