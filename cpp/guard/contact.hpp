#pragma once

// Whether a stream of positions keeps clear, certified between its samples as well, of obstacles
// that may move too.

#include <limits>
#include <optional>
#include <vector>

#include "collision/clearance.hpp"
#include "guard/step_limits.hpp"

namespace leadthrough::guard {

// growth: by how much an obstacle may come nearer in a period, m, one for each.
struct GuardedScene {
  WholeArm arm;
  std::vector<double> growth;  // of each pair of shapes
};
// Pairs that touch by their URDF are left out: no margin can be kept between them.
GuardedScene guarded_scene(const CollisionModel& model, const PlacedShapes& obstacles,
                           const std::vector<double>& growth, double margin,
                           double self_collision_margin);

// First time at which two bodies come nearer than their margin, as a sample's number with a
// fraction. Without bodies: the sample at which the permitted effort ended.
struct Contact {
  double sample = 0.0;
  int a = -1, b = -1;
};
constexpr long kAllWork = std::numeric_limits<long>::max();

// Along the samples from `start` (joints,) on, straight and in proportion in between. age: periods
// since the obstacles were where they are said to be. Nothing that is clear comes nearer than the
// margin by more than 0.1 mm, or touches. most_work: pairs of shapes that are looked at, each time
// that they are; a motion that grazes something takes a hundred times as many as one far from all.
std::optional<Contact> first_contact(const GuardedScene& scene, const Eigen::VectorXd& start,
                                     const RowsRef& samples, double age, long most_work = kAllWork);

}  // namespace leadthrough::guard
