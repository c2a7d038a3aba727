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

ClearanceTest::ClearanceTest(const WholeArm& arm) : arm_(arm), placed_(arm.scene) {}

bool ClearanceTest::clear(const double* q, double slack) {
  placed_.move_to(q);
  const auto holds = [&](std::size_t i) {
    return placed_.apart(i, arm_.margins[i] - slack - kTouching);
  };
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
  placed_.move_to(q);
  found.clear();
  for (std::size_t i = 0; i < arm_.scene.pairs.size(); ++i) {
    const double within = arm_.margins[i] + band;
    if (placed_.ball(i) >= within) continue;
    const Separation separated = placed_.separation(i, within);
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
      const Transform& frame = placed_.frames()[k + 1];
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
