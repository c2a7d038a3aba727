// Shapes of an arm, the joints that move them, and the pairs of them to check.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <variant>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/collision/scene.hpp"

namespace leadthrough {

namespace {

using collision::Frames;
using urdf::Robot;

Transform moved(const urdf::Joint& joint, double value) {
  const Transform& at_zero = joint.T_parent_child;
  if (joint.type == urdf::JointType::kFixed || joint.type == urdf::JointType::kPlanar ||
      joint.type == urdf::JointType::kFloating)
    return at_zero;
  if (joint.type == urdf::JointType::kPrismatic)
    return at_zero * Transform{Eigen::Matrix3d::Identity(), value * joint.axis};
  return at_zero * Transform{Eigen::AngleAxisd(value, joint.axis).toRotationMatrix(),
                             Eigen::Vector3d::Zero()};
}

// Placement of a link: the frame that it moves with, and its pose at zero.
struct Place {
  int frame = 0;
  Transform T_root_link;
};

// Joints that move, from the base to the tip, as marks on the robot's joints.
std::vector<bool> joints_of_chain(const Robot& robot, const std::string& base,
                                  const std::string& tip) {
  const auto joints = joints_between(robot, base, tip);
  if (const auto* error = std::get_if<urdf::Error>(&joints))
    throw std::invalid_argument(error->where + ": " + error->why);
  std::vector<bool> among(robot.joints.size(), false);
  for (const urdf::Joint* joint : std::get<0>(joints))
    among[static_cast<std::size_t>(joint - robot.joints.data())] =
        joint->type != urdf::JointType::kFixed;
  return among;
}

// Joints precede those below their child.
std::vector<Place> places(const Robot& robot, const std::vector<bool>& among) {
  std::vector<Place> result(robot.links.size());
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const urdf::Joint& joint = robot.joints[i];
    const double held = std::clamp(0.0, joint.lower, joint.upper);
    const Place& parent = result[static_cast<std::size_t>(joint.parent)];
    result[static_cast<std::size_t>(joint.child)] = {
        parent.frame + (among[i] ? 1 : 0),
        parent.T_root_link * moved(joint, among[i] ? 0.0 : held)};
  }
  return result;
}

Convex to_convex(const urdf::Geometry& collision) {
  switch (collision.type) {
    case urdf::GeometryType::kBox:
      return box(collision.size);
    case urdf::GeometryType::kCylinder:
      return cylinder(collision.radius, collision.length);
    case urdf::GeometryType::kCapsule:
      return capsule(collision.radius, collision.length);
    case urdf::GeometryType::kSphere:
      return sphere(collision.radius);
    case urdf::GeometryType::kMesh:
      break;  // its parts are given
  }
  return {};
}

void add_shape(std::vector<BodyShape>& shapes, int body, const Convex& convex,
               const Transform& T_frame_shape) {
  shapes.push_back({convex, T_frame_shape, body, bounding_radius(convex)});
}

// A mesh's frame may lie far from it: the bounding ball needs the middle as origin.
void add_hull(std::vector<BodyShape>& shapes, int body, const Eigen::Matrix3Xd& vertices,
              const Transform& T_frame_mesh) {
  const Eigen::Vector3d middle =
      0.5 * (vertices.rowwise().minCoeff() + vertices.rowwise().maxCoeff());
  add_shape(shapes, body, hull(vertices.colwise() - middle),
            T_frame_mesh * Transform{Eigen::Matrix3d::Identity(), middle});
}

Eigen::Matrix3Xd joined(const MeshParts& parts) {
  Eigen::Matrix3Xd all(3, 0);
  for (const Eigen::Matrix3Xd& part : parts) {
    all.conservativeResize(3, all.cols() + part.cols());
    all.rightCols(part.cols()) = part;
  }
  return all;
}

// Puts the parts of meshes in place of their hulls, in the pairs too. parts: of each shape, or none
// where it stays.
void decompose(CollisionModel& model, std::vector<std::vector<BodyShape>> parts) {
  std::vector<int> first;
  std::vector<BodyShape> shapes;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].empty()) parts[i].push_back(model.shapes[i]);
    first.push_back(static_cast<int>(shapes.size()));
    shapes.insert(shapes.end(), parts[i].begin(), parts[i].end());
  }
  first.push_back(static_cast<int>(shapes.size()));
  std::vector<ShapePair> pairs;
  for (const auto& [hull_a, hull_b] : model.pairs)
    for (int a = first[index(hull_a)]; a < first[index(hull_a) + 1]; ++a)
      for (int b = first[index(hull_b)]; b < first[index(hull_b) + 1]; ++b) pairs.push_back({a, b});
  model.shapes = std::move(shapes);
  model.pairs = std::move(pairs);
  for (BodyShape& shape : model.shapes)
    shape.cover = std::make_shared<const BallCover>(ball_cover(shape.convex));
}

// The nearest link towards the root that has shapes is a link's neighbour, as one of bodies.
std::vector<int> neighbours(const Robot& robot, const std::vector<int>& body_of_link) {
  std::vector<int> above(robot.links.size(), -1);
  for (const urdf::Joint& joint : robot.joints) {
    const auto parent = static_cast<std::size_t>(joint.parent);
    above[static_cast<std::size_t>(joint.child)] =
        body_of_link[parent] >= 0 ? body_of_link[parent] : above[parent];
  }
  return above;
}

// Points that cover a unit cube evenly: multiples of powers of the root of x^(d + 1) = x + 1,
// modulo one (Roberts 2018).
JointVector sample(const Chain& chain, int index) {
  const int joints = chain.joints();
  double root = 2.0;
  for (int i = 0; i < 60; ++i) root = std::pow(1.0 + root, 1.0 / (joints + 1));
  JointVector q(joints);
  double step = 1.0;
  for (int i = 0; i < joints; ++i) {
    const auto [lower, upper] = sampled_range(chain, i);
    step /= root;
    q[i] = lower + std::fmod(0.5 + step * (index + 1), 1.0) * (upper - lower);
  }
  return q;
}

// Two bodies, their shapes, and the statistics of their samples.
struct Candidate {
  int a, b;
  std::vector<ShapePair> pairs;
  bool near = false;
  bool apart = false;

  bool decided() const { return near && apart; }
};

void look(const CollisionModel& model, const std::vector<Transform>& poses, double margin,
          Candidate& candidate) {
  double distance = margin;
  for (const ShapePair& pair : candidate.pairs) {
    const auto a = static_cast<std::size_t>(pair.a);
    const auto b = static_cast<std::size_t>(pair.b);
    const BodyShape& one = model.shapes[a];
    const BodyShape& other = model.shapes[b];
    if (collision::ball_distance(one, poses[a], other, poses[b]) >= distance) continue;
    const double found =
        separation(one.convex, poses[a], other.convex, poses[b], distance).distance;
    distance = std::min(distance, found);
  }
  candidate.near = candidate.near || distance < margin;
  candidate.apart = candidate.apart || distance > 0.0;
}

// All pairs of bodies that can move against each other and are no neighbours.
std::vector<Candidate> candidates(CollisionModel& model, const std::vector<int>& neighbour) {
  std::vector<Candidate> result;
  const int count = static_cast<int>(model.bodies.size());
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      const int frame_a = model.bodies[index(a)].frame;
      const int frame_b = model.bodies[index(b)].frame;
      if (frame_a == frame_b) continue;
      if (neighbour[static_cast<std::size_t>(a)] == b ||
          neighbour[static_cast<std::size_t>(b)] == a)
        model.left_out.push_back({a, b, LeftOut::kAdjacent});
      else
        result.push_back(frame_a < frame_b ? Candidate{a, b, {}} : Candidate{b, a, {}});
    }
  }
  for (Candidate& candidate : result)
    for (std::size_t i = 0; i < model.shapes.size(); ++i)
      for (std::size_t j = 0; j < model.shapes.size(); ++j)
        if (model.shapes[i].body == candidate.a && model.shapes[j].body == candidate.b)
          candidate.pairs.push_back({static_cast<int>(i), static_cast<int>(j)});
  return result;
}

// Number of samples in which two shapes of bodies that can collide touch exactly, and overlap.
struct Contacts {
  int touching = 0;
  int overlapping = 0;
};

// Calls visit(sample, poses of the shapes) for so many samples.
template <typename Visit>
void at_samples(const CollisionModel& model, int count, const Visit& visit) {
  std::vector<Transform> poses;
  std::vector<int> frame_of;
  for (const BodyShape& shape : model.shapes) {
    poses.push_back(shape.T_frame_shape);
    frame_of.push_back(model.bodies[index(shape.body)].frame);
  }
  Frames frames;
  MovingValues room;
  for (int i = 0; i < count; ++i) {
    check_interrupt();
    const JointVector q = sample(model.chain, i);
    collision::joint_frames(model.chain, moving_values(model.chain, q.data(), room), frames);
    collision::place(model.shapes, frame_of, frames, poses);
    visit(i, poses);
  }
}

// Marks pairs that touch and never overlap.
void find_meeting_pairs(CollisionModel& model) {
  constexpr int kFew = 64, kMany = 2000;  // configurations: to find contacts; to exclude overlaps
  std::vector<Contacts> seen(model.pairs.size());
  at_samples(model, kMany, [&](int i, const std::vector<Transform>& poses) {
    for (std::size_t k = 0; k < seen.size(); ++k) {
      if (seen[k].overlapping > 0 || (i >= kFew && seen[k].touching == 0)) continue;
      const auto a = static_cast<std::size_t>(model.pairs[k].a);
      const auto b = static_cast<std::size_t>(model.pairs[k].b);
      const double distance = separation(model.shapes[a].convex, poses[a], model.shapes[b].convex,
                                         poses[b], 2.0 * kTouching)
                                  .distance;
      if (distance < -kTouching) ++seen[k].overlapping;
      if (std::abs(distance) <= kTouching) ++seen[k].touching;
    }
  });
  for (const Contacts& each : seen)
    model.meet.push_back(each.overlapping == 0 && each.touching > 0);
}

void choose_pairs(CollisionModel& model, const std::vector<int>& neighbour,
                  const PairOptions& options) {
  std::vector<Candidate> open = candidates(model, neighbour);
  at_samples(model, options.samples, [&](int, const std::vector<Transform>& poses) {
    for (Candidate& candidate : open)
      if (!candidate.decided()) look(model, poses, options.margin, candidate);
  });
  for (const Candidate& candidate : open) {
    if (candidate.decided())
      model.pairs.insert(model.pairs.end(), candidate.pairs.begin(), candidate.pairs.end());
    else
      model.left_out.push_back(
          {candidate.a, candidate.b, candidate.apart ? LeftOut::kNever : LeftOut::kAlways});
  }
}

}  // namespace

CollisionModel make_collision_model(const Robot& robot, const Chain& chain, const std::string& base,
                                    const std::string& tip, const std::vector<MeshParts>& meshes,
                                    const PlacedShapes& attached, const PairOptions& options) {
  std::size_t asked = 0;
  for (const urdf::Link& link : robot.links)
    asked += index(std::count_if(
        link.collisions.begin(), link.collisions.end(),
        [](const urdf::Geometry& each) { return each.type == urdf::GeometryType::kMesh; }));
  check_argument(meshes.size() == asked, "meshes: expected the parts of each collision mesh");
  const std::vector<Place> links = places(robot, joints_of_chain(robot, base, tip));
  const auto first = static_cast<std::size_t>(urdf::find_link(robot, base));
  const auto last = static_cast<std::size_t>(urdf::find_link(robot, tip));
  CollisionModel model{chain, {}, {}, {}, {}, {}};
  Frames frames;
  collision::joint_frames(chain, MovingValues{}.data(), frames);
  // Links beside or above the base in the tree do not move either.
  const auto frame_of = [&](std::size_t link) { return links[link].frame; };
  const auto in_frame = [&](std::size_t link) {
    const Transform T_base_link = inverse(links[first].T_root_link) * links[link].T_root_link;
    return inverse(frames[index(frame_of(link))]) * T_base_link;
  };
  std::vector<int> body_of_link(robot.links.size(), -1);
  std::vector<std::vector<BodyShape>> parts;
  std::size_t mesh = 0;
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    const urdf::Link& link = robot.links[i];
    if (link.collisions.empty()) continue;
    const int body = body_of_link[i] = static_cast<int>(model.bodies.size());
    model.bodies.push_back({link.name, frame_of(i)});
    for (const urdf::Geometry& collision : link.collisions) {
      const Transform pose = in_frame(i) * collision.T_link_shape;
      parts.emplace_back();
      if (collision.type != urdf::GeometryType::kMesh) {
        add_shape(model.shapes, body, to_convex(collision), pose);
        continue;
      }
      add_hull(model.shapes, body, joined(meshes[mesh]), pose);
      for (const Eigen::Matrix3Xd& part : meshes[mesh++]) add_hull(parts.back(), body, part, pose);
    }
  }
  const std::vector<int> above = neighbours(robot, body_of_link);
  std::vector<int> neighbour(model.bodies.size());
  for (std::size_t i = 0; i < robot.links.size(); ++i)
    if (body_of_link[i] >= 0) neighbour[static_cast<std::size_t>(body_of_link[i])] = above[i];
  if (!attached.empty()) {
    neighbour.push_back(body_of_link[last] >= 0 ? body_of_link[last] : above[last]);
    const int body = static_cast<int>(model.bodies.size());
    model.bodies.push_back({"attached", frame_of(last)});
    for (const PlacedShape& held : attached)
      add_shape(model.shapes, body, held.convex, in_frame(last) * held.pose);
    parts.resize(model.shapes.size());
  }
  // By hulls: those of links that are nested by design always overlap, their parts in most samples.
  choose_pairs(model, neighbour, options);
  decompose(model, std::move(parts));
  find_meeting_pairs(model);
  return model;
}

CollisionModel without_meeting_pairs(const CollisionModel& model) {
  CollisionModel result = model;
  result.pairs.clear();
  for (std::size_t i = 0; i < model.pairs.size(); ++i)
    if (!model.meet[i]) result.pairs.push_back(model.pairs[i]);
  result.meet.assign(result.pairs.size(), false);
  return result;
}

}  // namespace leadthrough
