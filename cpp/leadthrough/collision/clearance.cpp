#include "leadthrough/collision/clearance.hpp"

#include <Eigen/Geometry>

namespace leadthrough {

WholeArm whole_arm(const CollisionModel& model, const PlacedShapes& obstacles, double margin,
                   double self_collision_margin) {
  WholeArm arm{against(model, obstacles), {}};
  arm.margins.assign(arm.scene.pairs.size(), margin);
  arm.scene.pairs.insert(arm.scene.pairs.end(), model.pairs.begin(), model.pairs.end());
  arm.margins.resize(arm.scene.pairs.size(), self_collision_margin);
  return arm;
}

ClearanceTest::ClearanceTest(const WholeArm& arm)
    : arm_(arm), normals_(arm.scene.pairs.size(), Eigen::Vector3d::UnitX()) {
  for (const BodyShape& shape : arm.scene.shapes) poses_.push_back(shape.T_frame_shape);
}

void ClearanceTest::move_to(const double* q) {
  const CollisionScene& scene = arm_.scene;
  MovingValues room;
  collision::joint_frames(scene.chain, moving_values(scene.chain, q, room), frames_);
  collision::place(scene.shapes, scene.frames, frames_, poses_);
}

double ClearanceTest::ball(const ShapePair& pair) const {
  const auto& shapes = arm_.scene.shapes;
  return collision::ball_distance(shapes[index(pair.a)], poses_[index(pair.a)],
                                  shapes[index(pair.b)], poses_[index(pair.b)]);
}

// True if the distance of pair i is at least `least`, m.
bool ClearanceTest::apart(std::size_t i, double least) {
  const ShapePair& pair = arm_.scene.pairs[i];
  if (ball(pair) >= least) return true;
  const auto& shapes = arm_.scene.shapes;
  return collision::apart(shapes[index(pair.a)], poses_[index(pair.a)], shapes[index(pair.b)],
                          poses_[index(pair.b)], least, normals_[i]);
}

bool ClearanceTest::clear(const double* q, double slack) {
  move_to(q);
  const auto holds = [&](std::size_t i) { return apart(i, arm_.margins[i] - slack - kTouching); };
  const std::size_t pairs = arm_.scene.pairs.size();
  if (pairs == 0) return true;
  // The pair in collision at the last configuration is likely to collide again.
  if (!holds(blocker_)) return false;
  for (std::size_t i = 0; i < pairs; ++i) {
    if (i == blocker_ || holds(i)) continue;
    blocker_ = i;
    return false;
  }
  return true;
}

void ClearanceTest::near(const double* q, double band, std::vector<NearPair>& found) {
  move_to(q);
  found.clear();
  for (std::size_t i = 0; i < arm_.scene.pairs.size(); ++i) {
    const ShapePair& pair = arm_.scene.pairs[i];
    const double within = arm_.margins[i] + band;
    if (ball(pair) >= within) continue;
    const auto& shapes = arm_.scene.shapes;
    const Separation separated =
        collision::separation(shapes[index(pair.a)], poses_[index(pair.a)], shapes[index(pair.b)],
                              poses_[index(pair.b)], within);
    if (separated.distance < within) found.push_back(with_gradient(i, separated));
  }
}

// The nearest points move with their bodies; joints that move both bodies have no effect.
NearPair ClearanceTest::with_gradient(std::size_t i, const Separation& found) const {
  const CollisionScene& scene = arm_.scene;
  const ShapePair& pair = scene.pairs[i];
  NearPair near{i, found.distance, {}};
  const auto add = [&](JointMask joints, const Eigen::Vector3d& point, double sign) {
    collision::for_each_joint(joints, [&](std::size_t k) {
      const Transform& frame = frames_[k + 1];
      const Eigen::Vector3d axis = frame.rotation.col(2);
      const Eigen::Vector3d velocity =
          scene.chain.prismatic[k] ? axis : axis.cross(point - frame.position);
      const Drive& drive = scene.chain.drives[k];
      near.gradient[index(drive.joint)] += sign * drive.multiplier * velocity.dot(found.normal);
    });
  };
  const JointMask a = scene.joints[index(pair.a)], b = scene.joints[index(pair.b)];
  add(b & ~a, found.on_b, 1.0);
  add(a & ~b, found.on_a, -1.0);
  return near;
}

}  // namespace leadthrough
