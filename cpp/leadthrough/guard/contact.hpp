#pragma once

// First contact of a stream of positions with obstacles, which may move too; certified between its
// samples as well.

#include <limits>
#include <optional>
#include <vector>

#include "leadthrough/collision/clearance.hpp"
#include "leadthrough/guard/step_limits.hpp"

namespace leadthrough::guard {

// The arm and its obstacles, with the largest approach of each obstacle per period.
struct GuardedScene {
  WholeArm arm;
  std::vector<double> growth;  // m per period, of each pair of shapes
};
// Pairs that touch by their URDF are left out. growth: of each obstacle, m per period.
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

// Along the samples from `start` (joints,) on, linear in between. age: periods since the obstacles'
// poses were observed. Without a contact no distance falls below its margin; what moves within
// 0.1 mm of it may count as a contact. most_work: limit on tests of pairs of shapes; a motion that
// grazes an obstacle takes a hundred times as many as one far from all.
std::optional<Contact> first_contact(const GuardedScene& scene, const Eigen::VectorXd& start,
                                     const RowsRef& samples, double age, long most_work = kAllWork);

}  // namespace leadthrough::guard
