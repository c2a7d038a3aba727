#include "leadthrough/collision/side_by_side.hpp"

#include <algorithm>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/collision/motion_bound.hpp"
#include "leadthrough/collision/scene.hpp"

namespace leadthrough {

namespace {

JointVector stacked(const JointVector& left, const JointVector& right) {
  JointVector both(left.size() + right.size());
  both << left, right;
  return both;
}

// One of the arms, and how many bodies, shapes and moving joints come before its own.
struct Side {
  const CollisionModel& arm;
  const CollisionModel& other;
  std::string prefix;
  Transform T_left_base;
  int bodies = 0, shapes = 0, joints = 0;
};

void add_bodies(CollisionModel& both, const Side& side, bool one_robot) {
  for (const Body& body : side.arm.bodies) {
    const bool unique = one_robot && body.name != "attached";
    both.bodies.push_back(
        {(unique ? "" : side.prefix) + body.name, body.frame > 0 ? body.frame + side.joints : 0});
  }
  for (BodyShape shape : side.arm.shapes) {
    if (side.arm.bodies[index(shape.body)].frame == 0)
      shape.T_frame_shape = side.T_left_base * shape.T_frame_shape;
    shape.body += side.bodies;
    both.shapes.push_back(std::move(shape));
  }
}

// Links of one robot are in both models; those that the other arm moves are checked as its own.
bool is_of_other(const Side& side, int body) {
  return side.arm.bodies[index(body)].frame == 0 && side.other.bodies[index(body)].frame > 0;
}

void add_own_pairs(CollisionModel& both, const Side& side, bool one_robot) {
  const auto body_of = [&](int shape) { return side.arm.shapes[index(shape)].body; };
  for (std::size_t i = 0; i < side.arm.pairs.size(); ++i) {
    const auto [a, b] = side.arm.pairs[i];
    if (one_robot && (is_of_other(side, body_of(a)) || is_of_other(side, body_of(b)))) continue;
    both.pairs.push_back({a + side.shapes, b + side.shapes});
    both.meet.push_back(side.arm.meet[i]);
  }
  for (const auto& [a, b, why] : side.arm.left_out)
    if (!one_robot || !(is_of_other(side, a) || is_of_other(side, b)))
      both.left_out.push_back({a + side.bodies, b + side.bodies, why});
}

// A ball that a shape never leaves.
struct Reachable {
  Eigen::Vector3d centre;
  double radius;
};
Reachable reachable(const CollisionModel& model, const BodyShape& shape) {
  const Chain& chain = model.chain;
  const MovingValues extent = collision::sampled_extent(chain);
  Reachable ball{shape.T_frame_shape.position, shape.radius};
  for (int frame = model.bodies[index(shape.body)].frame; frame > 0;) {
    const std::size_t k = index(frame - 1);
    ball.radius += ball.centre.norm() + (chain.prismatic[k] ? extent[k] : 0.0);
    ball.centre = chain.fixed[k].position;
    frame = chain.parent_frame[k];
  }
  return ball;
}

// Pairs of a body of the left arm and one of the right arm.
void add_pairs_between(CollisionModel& both, const Side& right, const ArmPlacement& placement,
                       double margin) {
  std::vector<Reachable> balls;
  std::vector<std::vector<int>> shapes(both.bodies.size());
  for (const BodyShape& shape : both.shapes) {
    shapes[index(shape.body)].push_back(static_cast<int>(balls.size()));
    balls.push_back(reachable(both, shape));
  }
  const auto come_near = [&](int one, int other) {
    for (const int a : shapes[index(one)])
      for (const int b : shapes[index(other)])
        if ((balls[index(a)].centre - balls[index(b)].centre).norm() <=
            balls[index(a)].radius + balls[index(b)].radius + margin)
          return true;
    return false;
  };
  for (int one = 0; one < right.bodies; ++one) {
    for (int other = right.bodies; other < static_cast<int>(both.bodies.size()); ++other) {
      const int frame = both.bodies[index(one)].frame,
                other_frame = both.bodies[index(other)].frame;
      if (placement.one_robot ? frame == 0 || other_frame == 0 : frame == 0 && other_frame == 0)
        continue;
      if (placement.shared_object && one == right.bodies - 1 && other_frame == both.chain.moving) {
        both.left_out.push_back({one, other, LeftOut::kAdjacent});
      } else if (!come_near(one, other)) {
        both.left_out.push_back({one, other, LeftOut::kNever});
      } else {
        for (const int a : shapes[index(one)])
          for (const int b : shapes[index(other)]) both.between_arms.push_back({a, b});
      }
    }
  }
}

}  // namespace

Chain side_by_side(const Chain& left, const Chain& right, const Transform& T_left_right,
                   const std::vector<std::string>& names) {
  const int before = left.moving;
  check_argument(before + right.moving <= kMaxJoints, "right: too many joints of both arms");
  check_argument(static_cast<int>(names.size()) == left.joints() + right.joints(),
                 "names: expected one for each joint");
  Chain both = left;
  both.joint_names = names;
  both.lower = stacked(left.lower, right.lower);
  both.upper = stacked(left.upper, right.upper);
  both.velocity = stacked(left.velocity, right.velocity);
  both.effort = stacked(left.effort, right.effort);
  std::copy_n(right.periodic.begin(), right.joints(), both.periodic.begin() + left.joints());
  both.moving += right.moving;
  both.mimics = left.mimics || right.mimics;
  both.mass += right.mass;
  for (int k = 0; k < right.moving; ++k) {
    const std::size_t from = index(k), to = index(before + k);
    both.prismatic[to] = right.prismatic[from];
    both.drives[to] = right.drives[from];
    both.drives[to].joint += left.joints();
    both.bodies[to] = right.bodies[from];
    both.fixed[to] = k == 0 ? T_left_right * right.fixed[0] : right.fixed[from];
    both.parent_frame[to] = k == 0 ? 0 : before + right.parent_frame[from];
  }
  both.fixed[index(both.moving)] = right.fixed[index(right.moving)];
  return both;
}

CollisionModel side_by_side(const CollisionModel& left, const CollisionModel& right,
                            const ArmPlacement& placement, const std::vector<std::string>& names,
                            double margin) {
  CollisionModel both{
      side_by_side(left.chain, right.chain, placement.T_left_right, names), {}, {}, {}, {}, {}};
  const Side first{left, right, "left_", {}};
  const Side second{right,
                    left,
                    "right_",
                    placement.T_left_right,
                    static_cast<int>(left.bodies.size()),
                    static_cast<int>(left.shapes.size()),
                    left.chain.moving};
  for (const Side& side : {first, second}) {
    add_bodies(both, side, placement.one_robot);
    add_own_pairs(both, side, placement.one_robot);
  }
  add_pairs_between(both, second, placement, margin);
  return both;
}

}  // namespace leadthrough
