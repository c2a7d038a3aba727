#include "leadthrough/collision/lane_balls.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/collision/motion_bound.hpp"

namespace leadthrough {

namespace {

using lanes::Flags;
using lanes::Values;

// Single precision places the points of an arm to some micrometres, m.
constexpr double kPlaced = 2e-5;
// Sums of rounded products stay below, relative.
constexpr double kRaised = 1.0 + 1e-5;
// Beyond it, rad, sine_and_cosine are less exact.
constexpr double kMaxAngle = 100.0;

float raised(double value) { return static_cast<float>(value * kRaised); }

std::array<float, 3> floats(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

// A box in the frame of a shape around all that reaches as far.
struct Around {
  Eigen::Vector3d middle, half;
};
template <typename Reach>
Around box_around(const Reach& reach) {
  Around box;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(i);
    const double high = reach(axis), low = -reach(Eigen::Vector3d(-axis));
    box.middle[i] = 0.5 * (high + low);
    box.half[i] = 0.5 * (high - low);
  }
  return box;
}

Around box_around(const BodyShape& shape) {
  if (shape.cloud)
    return box_around([&](const Eigen::Vector3d& along) { return shape.cloud->reach(along); });
  return box_around([&](const Eigen::Vector3d& along) {
    return std::visit([&](const auto& core) { return core.reach(along); }, shape.convex.core);
  });
}

}  // namespace

LaneBalls::LaneBalls(const WholeArm& arm)
    : chain_(arm.scene.chain), extent_(collision::sampled_extent(chain_)) {
  const CollisionScene& scene = arm.scene;
  for (std::size_t k = 0; k < moving_count(chain_); ++k) {
    const Transform& fixed = chain_.fixed[k];
    for (int i = 0; i < 9; ++i)
      fixed_[k][index(i)] = static_cast<float>(fixed.rotation(i / 3, i % 3));
    for (int i = 0; i < 3; ++i) fixed_[k][index(9 + i)] = static_cast<float>(fixed.position[i]);
  }
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < scene.shapes.size(); ++i) {
    places.push_back(scene.shapes[i].cover ? bodies_.size() : boxes_.size());
    if (scene.shapes[i].cover)
      add_body(scene.shapes[i], scene.frames[i]);
    else
      add_obstacle(scene.shapes[i]);
  }
  for (std::size_t i = 0; i < scene.pairs.size(); ++i) {
    const std::size_t a = index(scene.pairs[i].a), b = index(scene.pairs[i].b);
    std::size_t first_joint = 0;
    for (JointMask both = scene.joints[a] & scene.joints[b]; both != 0; both >>= 1U) ++first_joint;
    pairs_.push_back({places[a], places[b], first_joint,
                      raised(arm.margins[i] - kTouching + kPlaced), !scene.shapes[a].cover});
  }
  centres_.resize(balls_.size());
  for (std::size_t i = 0; i < 9; i += 4) frames_[0].rotation[i] += 1.0F;
}

void LaneBalls::add_body(const BodyShape& shape, int frame) {
  const std::size_t first = balls_.size();
  add_ball(shape.cover->whole, shape.T_frame_shape, frame);
  for (const Ball& part : shape.cover->parts) add_ball(part, shape.T_frame_shape, frame);
  bodies_.push_back({first, balls_.size(), false});
}

void LaneBalls::add_ball(const Ball& ball, const Transform& T_frame_shape, int frame) {
  const Eigen::Vector3d centre = T_frame_shape.rotation * ball.centre + T_frame_shape.position;
  BallInJoint placed{floats(centre), raised(ball.radius), frame, {}, {}};
  const MovingValues reach = collision::reach_of_point(chain_, frame, centre, 0.0, extent_);
  std::transform(reach.begin(), reach.end(), placed.reach.begin(), raised);
  balls_.push_back(placed);
}

void LaneBalls::add_obstacle(const BodyShape& shape) {
  const Around around = box_around(shape);
  const Transform& pose = shape.T_frame_shape;
  RoundedBox box{{},
                 floats(pose.rotation * around.middle + pose.position),
                 floats(around.half),
                 raised(shape.cloud ? 0.0 : shape.convex.rounding),
                 !shape.cloud && std::holds_alternative<cores::Cylinder>(shape.convex.core)};
  for (int i = 0; i < 9; ++i)
    box.rotation[index(i)] = static_cast<float>(pose.rotation(i % 3, i / 3));
  boxes_.push_back(box);
}

bool LaneBalls::set_edge(const MovingValues& start, const MovingValues& end) {
  std::array<float, kMaxJoints> change{};
  for (std::size_t k = 0; k < moving_count(chain_); ++k) {
    const double most = std::max(std::abs(start[k]), std::abs(end[k]));
    if (!(most <= (chain_.prismatic[k] ? extent_[k] : kMaxAngle))) return false;
    change[k] = raised(std::abs(end[k] - start[k]));
  }
  longest_motion_ = 0.0F;
  for (BallInJoint& ball : balls_) {
    for (std::size_t k = 0; k < index(ball.frame); ++k)
      ball.travel[k + 1] = ball.travel[k] + change[k] * ball.reach[k];
    longest_motion_ = std::max(longest_motion_, ball.travel[index(ball.frame)]);
  }
  return true;
}

[[gnu::always_inline]] inline void LaneBalls::place_frame(std::size_t k, const Values& value) {
  const Frame& before = frames_[index(chain_.parent_frame[k])];
  const std::array<float, 12>& fixed = fixed_[k];
  Frame line;
  for (std::size_t i = 0; i < 3; ++i) {
    const Values &x = before.rotation[3 * i], &y = before.rotation[3 * i + 1],
                 &z = before.rotation[3 * i + 2];
    for (std::size_t j = 0; j < 3; ++j)
      line.rotation[3 * i + j] = x * fixed[j] + y * fixed[3 + j] + z * fixed[6 + j];
    line.position.axis[i] = before.position.axis[i] + x * fixed[9] + y * fixed[10] + z * fixed[11];
  }
  Frame& frame = frames_[k + 1];
  frame = line;
  if (chain_.prismatic[k]) {
    for (std::size_t i = 0; i < 3; ++i) frame.position.axis[i] += value * line.rotation[3 * i + 2];
    return;
  }
  Values sine, cosine;
  lanes::sine_and_cosine(value, sine, cosine);
  for (std::size_t i = 0; i < 9; i += 3) {
    frame.rotation[i] = cosine * line.rotation[i] + sine * line.rotation[i + 1];
    frame.rotation[i + 1] = cosine * line.rotation[i + 1] - sine * line.rotation[i];
  }
}

[[gnu::always_inline]] inline void LaneBalls::place_ball(std::size_t ball) {
  const BallInJoint& placed = balls_[ball];
  const Frame& frame = frames_[index(placed.frame)];
  for (std::size_t i = 0; i < 3; ++i)
    centres_[ball].axis[i] = frame.position.axis[i] + frame.rotation[3 * i] * placed.centre[0] +
                             frame.rotation[3 * i + 1] * placed.centre[1] +
                             frame.rotation[3 * i + 2] * placed.centre[2];
}

[[gnu::always_inline]] inline void LaneBalls::place_parts(std::size_t body) {
  BallsOfBody& balls = bodies_[body];
  if (balls.placed) return;
  for (std::size_t i = balls.whole + 1; i < balls.end; ++i) place_ball(i);
  balls.placed = true;
}

// Bound on a ball's motion by the joints that do not move the other body of the pair.
[[gnu::always_inline]] inline float LaneBalls::own_motion(const Pair& pair, std::size_t ball,
                                                          float fraction) const {
  const BallInJoint& moved = balls_[ball];
  return fraction * (moved.travel[index(moved.frame)] - moved.travel[pair.first_joint]);
}

[[gnu::always_inline]] inline void LaneBalls::clear_of_box(const RoundedBox& box, std::size_t ball,
                                                           float least, Flags& flags) const {
  const Point& centre = centres_[ball];
  const Values x = centre.axis[0] - box.position[0], y = centre.axis[1] - box.position[1],
               z = centre.axis[2] - box.position[2];
  Point local;
  for (std::size_t i = 0; i < 3; ++i)
    local.axis[i] =
        x * box.rotation[3 * i] + y * box.rotation[3 * i + 1] + z * box.rotation[3 * i + 2];
  if (box.round) {
    local.axis[0] = local.axis[0] * local.axis[0] + local.axis[1] * local.axis[1];
    lanes::root(local.axis[0]);
    local.axis[1] *= 0.0F;
  }
  Values squared{};
  for (std::size_t i = 0; i < 3; ++i) {
    lanes::magnitude(local.axis[i]);
    local.axis[i] -= box.half[i];
    lanes::not_negative(local.axis[i]);
    squared += local.axis[i] * local.axis[i];
  }
  const float beyond = least + box.rounding;
  flags = squared >= beyond * beyond;
}

[[gnu::always_inline]] inline void LaneBalls::clear_of_ball(std::size_t a, std::size_t b,
                                                            float least, Flags& flags) const {
  Values squared{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Values apart = centres_[a].axis[i] - centres_[b].axis[i];
    squared += apart * apart;
  }
  const float beyond = least + balls_[a].radius;
  flags = squared >= beyond * beyond;
}

[[gnu::always_inline]] inline void LaneBalls::pass_obstacle(const Pair& pair, float fraction,
                                                            Flags& flags) {
  const RoundedBox& box = boxes_[pair.a];
  const std::size_t whole = bodies_[pair.b].whole;
  const auto least = [&](std::size_t i) {
    return pair.margin + balls_[i].radius + own_motion(pair, i, fraction);
  };
  clear_of_box(box, whole, least(whole), flags);
  if (lanes::all(flags)) return;
  place_parts(pair.b);
  Flags parts = flags | -1;
  for (std::size_t i = whole + 1; i < bodies_[pair.b].end; ++i) {
    Flags part;
    clear_of_box(box, i, least(i), part);
    parts &= part;
  }
  flags |= parts;
}

[[gnu::always_inline]] inline void LaneBalls::pass_bodies(const Pair& pair, float fraction,
                                                          Flags& flags) {
  const BallsOfBody& a = bodies_[pair.a];
  const BallsOfBody& b = bodies_[pair.b];
  const auto least = [&](std::size_t j, std::size_t i) {
    return pair.margin + balls_[i].radius + own_motion(pair, i, fraction) +
           own_motion(pair, j, fraction);
  };
  clear_of_ball(a.whole, b.whole, least(a.whole, b.whole), flags);
  if (lanes::all(flags)) return;
  place_parts(pair.a);
  place_parts(pair.b);
  Flags parts = flags | -1;
  for (std::size_t i = b.whole + 1; i < b.end; ++i) {
    for (std::size_t j = a.whole + 1; j < a.end; ++j) {
      Flags part;
      clear_of_ball(j, i, least(j, i), part);
      parts &= part;
    }
  }
  flags |= parts;
}

[[gnu::always_inline]] inline void LaneBalls::run_here(const Joints& values, float fraction,
                                                       const std::vector<std::size_t>& open,
                                                       std::vector<Passed>& passed) {
  for (std::size_t k = 0; k < moving_count(chain_); ++k) place_frame(k, values.value[k]);
  for (BallsOfBody& body : bodies_) {
    place_ball(body.whole);
    body.placed = false;
  }
  for (std::size_t i = 0; i < open.size(); ++i) {
    const Pair& pair = pairs_[open[i]];
    Flags flags;
    if (pair.obstacle)
      pass_obstacle(pair, fraction, flags);
    else
      pass_bodies(pair, fraction, flags);
    lanes::to_bits(flags, passed[i]);
  }
}

#ifdef __x86_64__
[[gnu::target("avx2")]] void LaneBalls::run_wide(const Joints& values, float fraction,
                                                 const std::vector<std::size_t>& open,
                                                 std::vector<Passed>& passed) {
  run_here(values, fraction, open, passed);
}
#endif

void LaneBalls::run(const Joints& values, float fraction, const std::vector<std::size_t>& open,
                    std::vector<Passed>& passed) {
  run_here(values, fraction, open, passed);
}

void LaneBalls::test(const Joints& values, float fraction, const std::vector<std::size_t>& open,
                     std::vector<Passed>& passed) {
  passed.resize(open.size());
#ifdef __x86_64__
  static const bool kWide = __builtin_cpu_supports("avx2") != 0;
  if (kWide) return run_wide(values, fraction, open, passed);
#endif
  run(values, fraction, open, passed);
}

}  // namespace leadthrough
