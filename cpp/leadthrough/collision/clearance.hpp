#pragma once

// Tests of whether configurations are collision-free, and the pairs near contact: quicker than
// distances, for searches with thousands of queries.

#include <vector>

#include "leadthrough/collision/scene.hpp"

namespace leadthrough {

// All pairs of shapes that are checked, each with its required distance, m.
struct WholeArm {
  CollisionScene scene;
  std::vector<double> margins;
};
WholeArm whole_arm(const CollisionModel& model, const PlacedShapes& obstacles, double margin,
                   double self_collision_margin);

// Two shapes that are near each other. gradient: of their distance, m per unit of each joint.
struct NearPair {
  std::size_t pair;
  double distance;
  std::array<double, kMaxJoints> gradient;
};

// One per thread: it caches separating normals, which affects its speed and no result.
class ClearanceTest {
 public:
  explicit ClearanceTest(const WholeArm& arm);

  // True if the distance of every pair is at least its margin less `slack`; contact is clear.
  bool clear(const double* q, double slack = 0.0);
  // The pair that was too near when `clear` last returned false.
  std::size_t blocker() const { return blocker_; }

  // The pairs that are nearer than their margin and `band`, m.
  void near(const double* q, double band, std::vector<NearPair>& found);

 private:
  NearPair with_gradient(std::size_t i, const Separation& found) const;

  const WholeArm& arm_;
  collision::PlacedScene placed_;
  std::size_t blocker_ = 0;
};

}  // namespace leadthrough
