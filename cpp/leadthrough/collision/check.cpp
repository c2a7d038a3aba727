#include "leadthrough/collision/check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/base/parallel.hpp"
#include "leadthrough/collision/motion_bound.hpp"
#include "leadthrough/collision/scene.hpp"

namespace leadthrough {

namespace {

constexpr Eigen::Index kBlock = 64;  // rows that one thread takes at a time

// A scene at one configuration; made once for many.
class Placement {
 public:
  explicit Placement(const CollisionScene& scene)
      : scene_(scene), placed_(scene), balls_(scene.pairs.size()), order_(scene.pairs.size()) {}

  void move_to(const double* q) {
    placed_.move_to(q);
    for (std::size_t i = 0; i < balls_.size(); ++i) balls_[i] = placed_.ball(i);
  }

  // The two nearest bodies. The pair with the nearest balls is tested first, or the one that was
  // nearest before, if its balls overlap about as far; then the others by their balls: most are
  // excluded.
  Nearest nearest() {
    constexpr double kAsFar = 0.7;
    Nearest best;
    if (balls_.empty()) return best;
    auto first =
        static_cast<std::size_t>(std::min_element(balls_.begin(), balls_.end()) - balls_.begin());
    if (balls_[nearest_] < kAsFar * balls_[first]) first = nearest_;
    const std::size_t before = std::exchange(nearest_, first);
    measure(first, kInfinity, best);
    order_.clear();
    for (std::size_t i = 0; i < balls_.size(); ++i)
      if (i != first && balls_[i] < best.distance) order_.push_back(i);
    std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
      return std::tuple(a != before, balls_[a], a) < std::tuple(b != before, balls_[b], b);
    });
    for (const std::size_t i : order_) {
      const double least = best.distance;
      if (balls_[i] < least && measure(i, least, best) < least) nearest_ = i;
    }
    return best;
  }

  // Keeps the nearer of `best` and pair i, and returns the pair's distance, or a value from
  // `cutoff` up to it.
  double measure(std::size_t i, double cutoff, Nearest& best) const {
    const Separation found = placed_.separation(i, cutoff);
    if (found.distance < best.distance)
      best = {found.distance, body(scene_.pairs[i].a), body(scene_.pairs[i].b), found.on_a,
              found.on_b};
    return found.distance;
  }

  double ball(std::size_t i) const { return balls_[i]; }

 private:
  int body(int shape) const { return scene_.shapes[index(shape)].body; }

  const CollisionScene& scene_;
  collision::PlacedScene placed_;
  std::vector<double> balls_;
  std::vector<std::size_t> order_;
  std::size_t nearest_ = 0;  // pair at the last configuration
};

// Between two samples: the nearest approach and the first hit, if it is not at the first sample.
struct Interval {
  ClosestPair closest;
  std::optional<ClosestPair> first;
};

// Conservative advancement (Mirtich 1996): from a configuration the arm advances by as much as the
// distances allow before any could fall below a threshold.
class Motion {
 public:
  Motion(const CollisionScene& scene, const RowsRef& q, const MotionOptions& options)
      : scene_(scene),
        q_(q),
        options_(options),
        reach_(collision::reaches(scene, extents(scene.chain, q))) {
    for (const auto& [a, b] : scene.pairs) {
      raise(reach_[index(a)], scene.joints[index(a)] & ~scene.joints[index(b)]);
      raise(reach_[index(b)], scene.joints[index(b)] & ~scene.joints[index(a)]);
    }
  }

  // The largest absolute value of each moving joint.
  static MovingValues extents(const Chain& chain, const RowsRef& q) {
    MovingValues extent{};
    for (std::size_t k = 0; k < moving_count(chain); ++k) {
      const Drive& drive = chain.drives[k];
      extent[k] = std::abs(drive.multiplier) * q.col(drive.joint).cwiseAbs().maxCoeff() +
                  std::abs(drive.offset);
    }
    return extent;
  }

  // least: the smallest distance of all samples; start, end: those of rows i and i + 1.
  Interval between(Eigen::Index i, const Nearest& start, const Nearest& end, double least,
                   Placement& placement, std::vector<double>& motion) const {
    Interval found;
    double longest = motion_bound(i);
    double local = std::min(start.distance, end.distance);
    bool hit = is_hit(start.distance);
    double share = 0.0;
    double here = start.distance;
    while (true) {
      check_interrupt();
      // Distances already known to be lower, or no hit, need no second test.
      const double threshold =
          (hit ? local : std::max(options_.margin, std::min(least, local))) - options_.tolerance;
      const auto clear = [&] {
        return 0.5 * (here + end.distance - longest * (1.0 - share)) >= threshold;
      };
      if (clear()) return found;
      if (share == 0.0) longest = pair_motions(i, motion);
      if (clear()) return found;
      const double step =
          share == 0.0 ? (here - threshold) / longest : free_share(placement, motion, threshold);
      share += step;
      if (share >= 1.0) return found;
      MovingValues q{};
      interpolate(i, share, q);
      placement.move_to(q.data());
      const Nearest nearest = placement.nearest();
      here = nearest.distance;
      const ClosestPair approach{nearest, static_cast<double>(i) + share};
      if (here < found.closest.nearest.distance) found.closest = approach;
      if (is_hit(here) && !found.first) found.first = approach;
      hit = hit || is_hit(here);
      local = std::min(local, here);
    }
  }

  bool is_hit(double distance) const { return distance < options_.margin - kTouching; }

  // Bound on what the pairs move between rows i and i + 1, m, without a look at each.
  double motion_bound(Eigen::Index i) const {
    const MovingValues change = changes(i);
    double sum = 0.0;
    for (std::size_t k = 0; k < moving_count(scene_.chain); ++k) sum += change[k] * most_reach_[k];
    return sum;
  }

  double pair_motions(Eigen::Index i, std::vector<double>& motion) const {
    const MovingValues change = changes(i);
    double longest = 0.0;
    for (std::size_t p = 0; p < scene_.pairs.size(); ++p) {
      motion[p] = collision::pair_motion(scene_, reach_, scene_.pairs[p], change);
      longest = std::max(longest, motion[p]);
    }
    return longest;
  }

 private:
  void raise(const MovingValues& reach, JointMask joints) {
    collision::for_each_joint(
        joints, [&](std::size_t k) { most_reach_[k] = std::max(most_reach_[k], reach[k]); });
  }

  MovingValues changes(Eigen::Index i) const {
    MovingValues change{};
    for (std::size_t k = 0; k < moving_count(scene_.chain); ++k) {
      const Drive& drive = scene_.chain.drives[k];
      change[k] = std::abs(drive.multiplier * (q_(i + 1, drive.joint) - q_(i, drive.joint)));
    }
    return change;
  }

  void interpolate(Eigen::Index i, double share, MovingValues& q) const {
    for (Eigen::Index k = 0; k < q_.cols(); ++k)
      q[static_cast<std::size_t>(k)] = (1.0 - share) * q_(i, k) + share * q_(i + 1, k);
  }

  // Fraction of the interval before any distance can fall below the threshold.
  static double free_share(const Placement& placement, const std::vector<double>& motion,
                           double threshold) {
    double share = 1.0;
    Nearest ignored;
    for (std::size_t p = 0; p < motion.size(); ++p) {
      const double enough = threshold + share * motion[p];
      if (placement.ball(p) >= enough) continue;
      const double distance = placement.measure(p, enough, ignored);
      if (distance < enough) share = (distance - threshold) / motion[p];
    }
    return share;
  }

  const CollisionScene& scene_;
  const RowsRef& q_;
  const MotionOptions& options_;
  std::vector<MovingValues> reach_;
  MovingValues most_reach_{};  // of any pair
};

CollisionScene bodies_of(const CollisionModel& model) {
  CollisionScene scene{model.chain, {}, model.shapes, {}, {}, {}};
  for (const Body& body : model.bodies) scene.names.push_back(body.name);
  for (const BodyShape& shape : model.shapes) {
    scene.frames.push_back(model.bodies[index(shape.body)].frame);
    scene.joints.push_back(collision::joints_of_frame(model.chain, scene.frames.back()));
  }
  return scene;
}

}  // namespace

CollisionScene itself(const CollisionModel& model) {
  CollisionScene scene = bodies_of(model);
  scene.pairs = model.pairs;
  return scene;
}

CollisionScene against(const CollisionModel& model, const PlacedShapes& obstacles) {
  CollisionScene scene = bodies_of(model);
  const int own = static_cast<int>(scene.shapes.size());
  int things = 0;
  for (const PlacedShape& placed : obstacles) {
    const int obstacle = static_cast<int>(scene.shapes.size());
    for (int i = 0; i < own; ++i)
      if (scene.frames[index(i)] > 0) scene.pairs.push_back({obstacle, i});
    if (!placed.piece) scene.names.push_back("obstacle " + std::to_string(things++));
    const int body = static_cast<int>(scene.names.size()) - 1;
    const double radius =
        placed.cloud ? placed.cloud->bounding_radius() : bounding_radius(placed.convex);
    scene.shapes.push_back({placed.convex, placed.pose, body, radius, placed.cloud});
    scene.frames.push_back(0);
    scene.joints.push_back(0);
  }
  scene.pairs.insert(scene.pairs.end(), model.between_arms.begin(), model.between_arms.end());
  return scene;
}

std::vector<Nearest> nearest_batch(const CollisionScene& scene, const RowsRef& q, int threads) {
  check_rows(scene.chain, q);
  std::vector<Nearest> found(static_cast<std::size_t>(q.rows()));
  for_each_block(q.rows(), kBlock, threads, [&](Eigen::Index first, Eigen::Index end) {
    Placement placement(scene);
    for (Eigen::Index i = first; i < end; ++i) {
      check_interrupt();
      placement.move_to(q.row(i).data());
      found[static_cast<std::size_t>(i)] = placement.nearest();
    }
  });
  return found;
}

MotionReport check_motion(const CollisionScene& scene, const RowsRef& q,
                          const MotionOptions& options) {
  check_argument(q.rows() > 0, "q: expected at least one configuration");
  check_argument(q.allFinite(), "q: expected finite numbers");
  check_argument(std::isfinite(options.margin), "margin: expected a finite distance");
  check_argument(longest_step(scene, q) <= kMaxTests * options.tolerance,
                 "q, tolerance: expected at most kMaxTests tests between two configurations");
  MotionReport report;
  report.samples.resize(static_cast<std::size_t>(q.rows()));
  if (scene.pairs.empty()) return report;
  report.samples = nearest_batch(scene, q, options.threads);
  const auto& samples = report.samples;
  double least = kInfinity;
  for (const Nearest& sample : samples) least = std::min(least, sample.distance);
  const Motion motion(scene, q, options);
  std::vector<Interval> intervals(samples.size());  // the last one stays empty
  for_each_block(q.rows() - 1, kBlock, options.threads, [&](Eigen::Index first, Eigen::Index end) {
    Placement placement(scene);
    std::vector<double> room(scene.pairs.size());
    for (Eigen::Index i = first; i < end; ++i) {
      const auto at = static_cast<std::size_t>(i);
      intervals[at] = motion.between(i, samples[at], samples[at + 1], least, placement, room);
    }
  });
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const ClosestPair sample{samples[i], static_cast<double>(i)};
    if (!report.first && motion.is_hit(sample.nearest.distance)) report.first = sample;
    if (!report.first) report.first = intervals[i].first;
    for (const ClosestPair& approach : {sample, intervals[i].closest})
      if (approach.nearest.distance < report.closest.nearest.distance) report.closest = approach;
  }
  return report;
}

double longest_step(const CollisionScene& scene, const RowsRef& q) {
  check_rows(scene.chain, q);
  if (q.rows() < 2) return 0.0;
  const MotionOptions options;
  const Motion motion(scene, q, options);
  std::vector<double> room(scene.pairs.size());
  double longest = 0.0;
  for (Eigen::Index i = 0; i + 1 < q.rows(); ++i) {
    check_interrupt();
    if (motion.motion_bound(i) > longest) longest = std::max(longest, motion.pair_motions(i, room));
  }
  return longest;
}

}  // namespace leadthrough
