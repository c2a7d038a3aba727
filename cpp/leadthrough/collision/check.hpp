#pragma once

// Collision of a whole arm: every shape of every link, against obstacles and against each other,
// at single configurations and along a motion without a gap between its samples.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/collision/ball_cover.hpp"
#include "leadthrough/collision/shapes.hpp"

namespace leadthrough {

// Bodies that overlap by less count as touching, m: distances are exact to a tenth of it.
constexpr double kTouching = 1e-6;

// A link, a thing that is attached to the tip, or an obstacle. frame: 0 is the base's, of what is
// fixed to it and of obstacles; frame i + 1 moves with the chain's moving joint i.
struct Body {
  std::string name;
  int frame;
};

// T_frame_shape: in the body's frame.
struct BodyShape {
  Convex convex;
  Transform T_frame_shape;
  int body;
  double radius;  // of a ball about the shape's origin that holds it, m
  std::shared_ptr<const Cloud> cloud = nullptr;      // of an obstacle, in place of a convex body
  std::shared_ptr<const BallCover> cover = nullptr;  // of the arm's own shapes
};

// Shapes that are checked against each other. Of one arm more joints move b than a.
struct ShapePair {
  int a, b;
};

// Bodies that are not checked against each other, and why.
enum class LeftOut { kAdjacent, kAlways, kNever };
struct BodyPair {
  int a, b;
  LeftOut why;
};

struct CollisionModel {
  Chain chain;
  std::vector<Body> bodies;
  std::vector<BodyShape> shapes;
  std::vector<ShapePair> pairs;
  std::vector<bool> meet;  // pairs that touch and never overlap: their URDF makes them meet
  std::vector<BodyPair> left_out;
  std::vector<ShapePair> between_arms = {};  // shapes of two arms, see side_by_side
};
// The model without the pairs that meet: no margin can hold between them.
CollisionModel without_meeting_pairs(const CollisionModel& model);

// Pairs are sampled at configurations spread evenly inside the limits: pairs that never come within
// `margin` and pairs that always touch are left out, as are adjacent links.
struct PairOptions {
  int samples = 4000;
  double margin = 0.05;  // m
};

// Vertices of the convex parts of a mesh.
using MeshParts = std::vector<Eigen::Matrix3Xd>;

// The model of the robot that `chain` is the arm of, from the links `base` to `tip`. Joints outside
// the chain stay at zero or at the limit next to it. meshes: in the order of links and their
// collisions; attached: in the frame of the tip link, without clouds.
CollisionModel make_collision_model(const urdf::Robot& robot, const Chain& chain,
                                    const std::string& base, const std::string& tip,
                                    const std::vector<MeshParts>& meshes,
                                    const PlacedShapes& attached, const PairOptions& options = {});

// Moving joints, one bit each.
using JointMask = std::uint32_t;

// Pairs to check: the arm's own, or its moving bodies against obstacles and another arm. Obstacles
// are bodies like the arm's own, after them and in their order, named "obstacle 0" and so on.
struct CollisionScene {
  Chain chain;
  std::vector<std::string> names;  // of the bodies
  std::vector<BodyShape> shapes;
  std::vector<int> frames;        // of each shape
  std::vector<JointMask> joints;  // that move each shape
  std::vector<ShapePair> pairs;
};
CollisionScene itself(const CollisionModel& model);
CollisionScene against(const CollisionModel& model, const PlacedShapes& obstacles);

// The closest pair of bodies; the distance is infinite if no pair is checked. Points in the base
// frame.
struct Nearest {
  double distance = kInfinity;
  int a = -1;
  int b = -1;
  Eigen::Vector3d on_a = Eigen::Vector3d::Zero();
  Eigen::Vector3d on_b = Eigen::Vector3d::Zero();
};

// One answer a row of q; the same for any number of threads.
std::vector<Nearest> nearest_batch(const CollisionScene& scene, const RowsRef& q, int threads);

// The closest pair along a motion. sample: index of a row of q plus the fraction of the step to the
// next.
struct ClosestPair {
  Nearest nearest;
  double sample = 0.0;
};

// Tests between two samples of a motion; more would take minutes.
constexpr double kMaxTests = 1e6;

struct MotionOptions {
  double margin = 0.0;      // m; a distance below it is a hit, contact alone is none
  double tolerance = 1e-3;  // m
  int threads = 1;
};

// closest: the smallest distance of the whole motion, to the tolerance. first: the first hit; no
// earlier one is deeper than the tolerance.
struct MotionReport {
  std::vector<Nearest> samples;
  ClosestPair closest;
  std::optional<ClosestPair> first;
};

// Between rows the joints move straight and in proportion.
MotionReport check_motion(const CollisionScene& scene, const RowsRef& q,
                          const MotionOptions& options = {});

// Upper bound on the displacement of any point of the arm between two rows, m; the work of
// check_motion grows with its ratio to the tolerance.
double longest_step(const CollisionScene& scene, const RowsRef& q);

}  // namespace leadthrough
