#include "leadthrough/dmp/avoidance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough::dmp {

namespace {

using Eigen::Vector3d;

// Steering: gamma and beta of Hoffmann et al. 2009, with time measured in durations.
constexpr double kGain = 1000.0;
constexpr double kNarrowing = 20.0 / kPi;
// A motion straight at the middle is steered as at the angle of largest effect; the literature's
// term vanishes there.
constexpr double kMinAngle = 1.0 / kNarrowing;
// Sine of the angle below which a rule chooses the side.
constexpr double kHeadOn = 1e-6;

constexpr int kSides = 16;  // on which an obstacle may be passed

constexpr double kBarrierRate = 60.0;  // per unit of phase, several times the springs'
constexpr double kSliding = 1.5;       // of what a barrier holds back, along the surface
constexpr double kInsistence = 4.0;    // of it, against forces in the opposite direction
constexpr int kSweeps = 4;             // over barriers that may act against each other
constexpr double kMaxStep = 1e-3;      // of phase, far below the barrier's time
// Steering weaker than this share of a barrier's push at the margin does not count as one.
constexpr double kNegligible = 1e-3;

Vector3d in_space(const Vector& channels, Eigen::Index dimensions) {
  Vector3d result = Vector3d::Zero();
  result.head(dimensions) = channels.head(dimensions);
  return result;
}

Vector start_of(const Course& course) { return course.reference.coefficients.row(0); }

// Unit vector perpendicular to a direction, away from the middle.
Vector3d sideways(const Vector3d& direction, const Vector3d& to_middle) {
  const Vector3d side = direction * direction.dot(to_middle) - to_middle;
  if (side.norm() > kHeadOn * to_middle.norm()) return side.normalized();
  const Vector3d up = direction.head<2>().norm() > kHeadOn ? Vector3d::UnitZ() : Vector3d::UnitX();
  return direction.cross(up).normalized();
}

Vector3d steering(const Obstacle& obstacle, double reach, double distance,
                  const Vector3d& to_middle, const Vector3d& velocity) {
  const double speed = velocity.norm();
  const double ahead = velocity.dot(to_middle);
  if (speed == 0.0 || ahead <= 0.0) return Vector3d::Zero();
  const double angle = std::atan2(velocity.cross(to_middle).norm(), ahead);
  const double effective = std::max(angle, kMinAngle);
  const double nearness = std::exp(-std::max(distance - obstacle.margin, 0.0) / reach);
  const double strength = kGain * effective * std::exp(-kNarrowing * effective) * nearness;
  return strength * speed * sideways(velocity / speed, to_middle);
}

// The smallest acceleration along the gradient of a distance h that satisfies its barrier.
double barrier(double h, double h_slope, double acceleration) {
  const double needed = -kBarrierRate * (2.0 * h_slope + kBarrierRate * h);
  return std::max(needed - acceleration, 0.0);
}

// The axis of the detour around an obstacle: perpendicular to the line from start to goal, or to
// the obstacle if they coincide, such that the detour beside the obstacle is the shortest.
Vector3d sense_of_passing(const Shape& shape, const Vector3d& start, const Vector3d& goal,
                          Eigen::Index dimensions) {
  Vector3d from_middle = start - shape.position;
  from_middle.tail(3 - dimensions).setZero();
  const bool closed = (goal - start).norm() < kHeadOn * from_middle.norm();
  const Vector3d along =
      (closed ? Vector3d(-from_middle) : Vector3d(goal - start)).stableNormalized();
  const Vector3d first = sideways(along, -from_middle);
  const Vector3d second = along.cross(first);
  Vector3d best = Vector3d::Zero();
  double shortest = std::numeric_limits<double>::max();
  for (int i = 0; i < kSides; ++i) {
    const double angle = kTurn * i / kSides;
    const Vector3d side = std::cos(angle) * first + std::sin(angle) * second;
    if (dimensions == 2 && std::abs(side.z()) > 0.5) continue;
    const double depth = reach_of(shape, side) - side.dot(from_middle);
    if (depth < shortest) {
      shortest = depth;
      best = side;
    }
  }
  return best.cross(along);
}

struct Near {
  SignedDistance clearance;
  const Obstacle* obstacle;
  Vector3d sense;
};

// Computes pushes; its arrays are workspace.
class Guard {
 public:
  Guard(const Forces& forces, const Course& course, const AvoidanceScene& scene)
      : forces_(forces),
        course_(course),
        scene_(scene),
        dimensions_(std::min<Eigen::Index>(forces.nodes.cols(), 3)),
        acceleration_(forces.nodes.cols()) {
    near_.reserve(scene.obstacles.size());
    senses_.reserve(scene.obstacles.size());
    for (const Obstacle& obstacle : scene.obstacles)
      senses_.push_back(sense_of_passing(obstacle.shape, in_space(start_of(course), dimensions_),
                                         in_space(end_of(course.reference), dimensions_),
                                         dimensions_));
  }

  // Adds to the push; true if anything was added.
  bool add(const State& state, Vector& push) {
    acceleration(forces_, course_, state, acceleration_);
    acceleration_ += push;
    const bool steered = steer(state, push);
    bool pushed = false;
    slide(state, push);
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      bool changed = keep_clear(state, push);
      changed |= keep_inside(state, push);
      pushed |= changed;
      if (!changed) break;
    }
    return steered || pushed;
  }

 private:
  bool steer(const State& state, Vector& push) {
    near_.clear();
    bool matters = false;
    const Vector3d position = in_space(state.value, dimensions_);
    const Vector3d velocity = in_space(state.slope, dimensions_);
    for (std::size_t i = 0; i < senses_.size(); ++i) {
      const Obstacle& obstacle = scene_.obstacles[i];
      Vector3d to_middle = obstacle.shape.position - position;
      to_middle.tail(3 - dimensions_).setZero();
      near_.push_back({signed_distance(obstacle.shape, position), &obstacle, senses_[i]});
      const Vector3d turn =
          steering(obstacle, scene_.reach, near_.back().clearance.distance, to_middle, velocity);
      change(turn.head(dimensions_), push);
      const double noticed = kNegligible * kBarrierRate * kBarrierRate * obstacle.margin;
      matters |= turn.norm() > noticed;
    }
    return matters;
  }

  // Motion that presses on a surface is led along it, always in the same direction, so that neither
  // a flat surface nor a corner stops it.
  void slide(const State& state, Vector& push) {
    for (const Near& near : near_) {
      const double pressure = missing(near, state);
      if (pressure == 0.0) continue;
      const Vector3d tangent = near.sense.cross(near.clearance.gradient);
      const double against = std::max(-tangent.dot(in_space(acceleration_, dimensions_)), 0.0);
      const double strength = kSliding * pressure + std::min(against, kInsistence * pressure);
      change(strength * tangent.head(dimensions_), push);
    }
  }

  double missing(const Near& near, const State& state) const {
    const auto gradient = near.clearance.gradient.head(dimensions_);
    const double h = near.clearance.distance - near.obstacle->margin;
    return barrier(h, gradient.dot(state.slope.head(dimensions_)),
                   gradient.dot(acceleration_.head(dimensions_)));
  }

  bool keep_clear(const State& state, Vector& push) {
    bool changed = false;
    for (const Near& near : near_) {
      const auto gradient = near.clearance.gradient.head(dimensions_);
      const double steepness = gradient.squaredNorm();
      const double lack = missing(near, state);
      if (lack == 0.0 || steepness < kHeadOn) continue;
      change(gradient * (lack / steepness), push);
      changed = true;
    }
    return changed;
  }

  bool keep_inside(const State& state, Vector& push) {
    bool changed = false;
    for (Eigen::Index i = 0; i < scene_.lower.size(); ++i) {
      const double value = state.value[i];
      const double slope = state.slope[i];
      const double up = barrier(value - scene_.lower[i], slope, acceleration_[i]);
      const double down = barrier(scene_.upper[i] - value, -slope, -acceleration_[i]);
      push[i] += up - down;
      acceleration_[i] += up - down;
      changed |= up > 0.0 || down > 0.0;
    }
    return changed;
  }

  template <typename Change>
  void change(const Change& by, Vector& push) {
    push.head(dimensions_) += by;
    acceleration_.head(dimensions_) += by;
  }

  const Forces& forces_;
  const Course& course_;
  const AvoidanceScene& scene_;
  Eigen::Index dimensions_;
  Vector acceleration_;
  std::vector<Vector3d> senses_;
  std::vector<Near> near_;
};

bool advance_guarded(const Forces& forces, const Course& course, Guard& guard, const Vector& push,
                     double span, Vector& total, State& state) {
  const auto steps = static_cast<int>(std::ceil(std::min(span, 1.0) / kMaxStep));
  bool pushed = false;
  const double beyond = std::max(span - 1.0, 0.0);
  for (int i = 0; i < steps; ++i) {
    check_interrupt();
    total = push;
    pushed |= guard.add(state, total);
    advance(forces, course, total, std::min(span, 1.0) / steps, state);
  }
  if (beyond > 0.0) advance(forces, course, push, beyond, state);
  return pushed;
}

}  // namespace

bool advance_around(const Forces& forces, const Course& course, const AvoidanceScene& scene,
                    const Vector& push, double span, State& state) {
  Guard guard(forces, course, scene);
  Vector total(push.size());
  return advance_guarded(forces, course, guard, push, span, total, state);
}

Passage rollout_around(const Forces& forces, const Course& course, const AvoidanceScene& scene,
                       State state, const VectorRef& phases) {
  check_run(forces, course, state, phases);
  check_argument(scene.lower.size() == 0 || scene.lower.size() == state.value.size(),
                 "scene: expected bounds of all channels, or none");
  const Eigen::Index count = phases.size();
  const Eigen::Index channels = state.value.size();
  const Vector no_push = Vector::Zero(channels);
  Vector total(channels);
  Guard guard(forces, course, scene);
  Passage result{{Rows(count, channels), Rows(count, channels)}, phases[0]};
  for (Eigen::Index n = 0; n < count; ++n) {
    check_interrupt();
    if (n > 0 &&
        advance_guarded(forces, course, guard, no_push, phases[n] - phases[n - 1], total, state))
      result.last_push = phases[n];
    result.rollout.values.row(n) = state.value;
    result.rollout.slopes.row(n) = state.slope;
  }
  return result;
}

}  // namespace leadthrough::dmp
