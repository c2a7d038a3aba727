#pragma once

// Placement of a collision model's shapes at a configuration, and distances of placed shapes.

#include <cmath>
#include <vector>

#include "leadthrough/arm/run_down.hpp"
#include "leadthrough/collision/check.hpp"

namespace leadthrough {

template <typename Integer>
std::size_t index(Integer i) {
  return static_cast<std::size_t>(i);
}

namespace collision {

// The base frame, then the frame that each moving joint carries.
using Frames = std::array<Transform, kMaxJoints + 1>;

// values: of the moving joints.
inline void joint_frames(const Chain& chain, const double* values, Frames& frames) {
  frames[0] = {};
  for (std::size_t k = 0; k < moving_count(chain); ++k) {
    const Transform line = frames[index(chain.parent_frame[k])] * chain.fixed[k];
    Transform& frame = frames[k + 1];
    frame = line;
    if (chain.prismatic[k]) {
      frame.position += values[k] * line.rotation.col(2);
    } else {
      const double cosine = std::cos(values[k]);
      const double sine = std::sin(values[k]);
      frame.rotation.col(0) = cosine * line.rotation.col(0) + sine * line.rotation.col(1);
      frame.rotation.col(1) = cosine * line.rotation.col(1) - sine * line.rotation.col(0);
    }
  }
}

// Poses of the shapes that are moved by at least one joint; the others stay as they are.
inline void place(const std::vector<BodyShape>& shapes, const std::vector<int>& frame_of,
                  const Frames& frames, std::vector<Transform>& poses) {
  for (std::size_t i = 0; i < shapes.size(); ++i)
    if (frame_of[i] > 0) poses[i] = frames[index(frame_of[i])] * shapes[i].T_frame_shape;
}

// The joints that move a frame.
inline JointMask joints_of_frame(const Chain& chain, int frame) {
  JointMask joints = 0;
  for (; frame > 0; frame = chain.parent_frame[index(frame - 1)])
    joints |= JointMask{1} << static_cast<unsigned>(frame - 1);
  return joints;
}

// Calls visit(k) for the joints of a mask, from the base on.
template <typename Visit>
void for_each_joint(JointMask joints, const Visit& visit) {
  for (; joints != 0; joints &= joints - 1) visit(index(__builtin_ctz(joints)));
}

// As of their convex bodies; only the first may be a cloud, as only obstacles are.
inline Separation separation(const BodyShape& a, const Transform& A, const BodyShape& b,
                             const Transform& B, double cutoff) {
  return a.cloud ? a.cloud->separation(A, b.convex, B, b.radius, cutoff)
                 : leadthrough::separation(a.convex, A, b.convex, B, cutoff);
}

// normal: of convex bodies only, see `apart` of those.
inline bool apart(const BodyShape& a, const Transform& A, const BodyShape& b, const Transform& B,
                  double least, Eigen::Vector3d& normal) {
  return a.cloud ? a.cloud->apart(A, b.convex, B, b.radius, least)
                 : leadthrough::apart(a.convex, A, b.convex, B, least, normal);
}

// The distance of the balls around two shapes.
inline double ball_distance(const BodyShape& a, const Transform& A, const BodyShape& b,
                            const Transform& B) {
  return (A.position - B.position).norm() - a.radius - b.radius;
}

// A scene's shapes at one configuration; made once for many. For one thread: it caches separating
// normals, which affects its speed and no result.
class PlacedScene {
 public:
  explicit PlacedScene(const CollisionScene& scene)
      : scene_(scene), normals_(scene.pairs.size(), Eigen::Vector3d::UnitX()) {
    for (const BodyShape& shape : scene.shapes) poses_.push_back(shape.T_frame_shape);
  }

  void move_to(const double* q) {
    MovingValues room;
    place_at(moving_values(scene_.chain, q, room));
  }

  // values: of the moving joints.
  void place_at(const double* values) {
    joint_frames(scene_.chain, values, frames_);
    place(scene_.shapes, scene_.frames, frames_, poses_);
  }

  const Frames& frames() const { return frames_; }

  // Distance of the balls around the shapes of pair p.
  double ball(std::size_t p) const {
    const auto [a, b] = scene_.pairs[p];
    return ball_distance(shape(a), pose(a), shape(b), pose(b));
  }

  Separation separation(std::size_t p, double cutoff) const {
    const auto [a, b] = scene_.pairs[p];
    return collision::separation(shape(a), pose(a), shape(b), pose(b), cutoff);
  }

  // True if the distance of pair p is at least `least`, m.
  bool apart(std::size_t p, double least) {
    if (ball(p) >= least) return true;
    const auto [a, b] = scene_.pairs[p];
    return collision::apart(shape(a), pose(a), shape(b), pose(b), least, normals_[p]);
  }

 private:
  const BodyShape& shape(int i) const { return scene_.shapes[index(i)]; }
  const Transform& pose(int i) const { return poses_[index(i)]; }

  const CollisionScene& scene_;
  Frames frames_;
  std::vector<Transform> poses_;
  std::vector<Eigen::Vector3d> normals_;  // the last separating direction of each pair
};

}  // namespace collision

}  // namespace leadthrough
