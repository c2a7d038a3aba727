// An interval is certified by the one configuration in its middle: a pair whose distance there
// exceeds its margin plus its largest motion in half the interval keeps the margin in all of it.
// Intervals of many samples are tried first; pairs that fail are tried again in the halves.

#include "leadthrough/guard/contact.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/collision/motion_bound.hpp"

namespace leadthrough::guard {

namespace {

using Eigen::Index;

// Closer to the margin than this, m, nothing moves that is not certified before.
constexpr double kTolerance = 1e-4;
// Smallest margin, m: distances are exact to less, and nothing may touch.
constexpr double kMinMargin = 2.0 * kTouching;
// The work of placing all shapes, in tests of pairs.
constexpr long kPlacing = 16;
// Bisections between two samples before a pair counts as too near.
constexpr int kMaxHalvings = 14;

class Certifier {
 public:
  Certifier(const GuardedScene& scene, const Eigen::VectorXd& start, const RowsRef& samples,
            double age, long most_work)
      : scene_(scene.arm.scene),
        guarded_(scene),
        samples_(samples),
        start_(start),
        age_(age),
        work_left_(most_work),
        travel_(index(samples.rows()) + 1),
        placed_(scene_) {
    MovingValues extent{};
    for (std::size_t k = 0; k < moving_count(scene_.chain); ++k) {
      double before = value(0, k);
      extent[k] = std::abs(before);
      for (Index i = 1; i <= samples_.rows(); ++i) {
        check_interrupt();
        const double here = value(i, k);
        extent[k] = std::max(extent[k], std::abs(here));
        travel_[index(i)][k] = travel_[index(i) - 1][k] + std::abs(here - before);
        before = here;
      }
    }
    reach_ = collision::reaches(scene_, extent);
    open_.reserve(scene_.pairs.size() * 64);
    for (std::size_t p = 0; p < scene_.pairs.size(); ++p) open_.push_back(p);
  }

  std::optional<Contact> run() {
    if (samples_.rows() > 0 && !open_.empty()) between(0, samples_.rows(), 0, open_.size());
    return contact_;
  }

 private:
  // Value of a moving joint after `i` samples.
  double value(Index i, std::size_t k) const {
    const Drive& drive = scene_.chain.drives[k];
    const double q = i == 0 ? start_[drive.joint] : samples_(i - 1, drive.joint);
    return drive.multiplier * q + drive.offset;
  }

  // Margin of a pair at that time, grown by the obstacle's largest possible motion.
  double margin(std::size_t p, double sample) const {
    return std::max(guarded_.arm.margins[p] + guarded_.growth[p] * (age_ + sample), kMinMargin);
  }

  void move_to(double sample) {
    const Index i = std::min(static_cast<Index>(sample), samples_.rows() - 1);
    const double fraction = sample - static_cast<double>(i);
    MovingValues values{};
    for (std::size_t k = 0; k < moving_count(scene_.chain); ++k)
      values[k] = (1.0 - fraction) * value(i, k) + fraction * value(i + 1, k);
    placed_.place_at(values.data());
  }

  // Adds those of the pairs in open_[first, end) that are not certified while the joints change by
  // at most `change` around the configuration of time `at`, with the margins of time `late`.
  void keep_open(std::size_t first, std::size_t end, const MovingValues& change, double at,
                 double late) {
    for (std::size_t i = first; i < end; ++i) {
      check_interrupt();
      const std::size_t p = open_[i];
      const double motion = collision::pair_motion(scene_, reach_, scene_.pairs[p], change);
      const double least = margin(p, late);
      if (placed_.apart(p, least - kTouching + motion)) continue;
      open_.push_back(p);
      fine_ = fine_ && least - margin(p, at) + motion > kTolerance;
    }
  }

  // Tests the samples after `low` up to `high`, for the pairs in open_[first, end).
  void between(Index low, Index high, std::size_t first, std::size_t end) {
    if (high - low == 1) return within(low, 0.0, 1.0, first, end, kMaxHalvings);
    if (!work(low, end - first)) return;
    const Index middle = low + (high - low) / 2;
    move_to(static_cast<double>(middle));
    MovingValues change{};
    for (std::size_t k = 0; k < moving_count(scene_.chain); ++k)
      change[k] = std::max(travel_[index(middle)][k] - travel_[index(low)][k],
                           travel_[index(high)][k] - travel_[index(middle)][k]);
    const std::size_t left = open_.size();
    keep_open(first, end, change, static_cast<double>(middle), static_cast<double>(high));
    const std::size_t right = open_.size();
    if (right > left) between(low, middle, left, right);
    if (right > left && !contact_) between(middle, high, left, right);
    open_.resize(left);
  }

  // The same between a sample and the next one, from one fraction of the step to another.
  void within(Index low, double from, double to, std::size_t first, std::size_t end, int halvings) {
    if (!work(low, 2 * (end - first))) return;
    const double middle = 0.5 * (from + to);
    const double at = static_cast<double>(low) + middle;
    move_to(at);
    for (std::size_t i = first; i < end; ++i)
      if (!placed_.apart(open_[i], margin(open_[i], at) - kTouching)) return touch(at, open_[i]);
    MovingValues change{};
    for (std::size_t k = 0; k < moving_count(scene_.chain); ++k)
      change[k] = (to - middle) * (travel_[index(low) + 1][k] - travel_[index(low)][k]);
    const std::size_t left = open_.size();
    fine_ = true;
    keep_open(first, end, change, at, static_cast<double>(low) + to);
    const std::size_t right = open_.size();
    if (right > left && (halvings == 0 || !fine_)) touch(at, open_[left]);
    if (right > left && !contact_) within(low, from, middle, left, right, halvings - 1);
    if (right > left && !contact_) within(low, middle, to, left, right, halvings - 1);
    open_.resize(left);
  }

  // Charges tests of `pairs` to the budget; false if exceeded. All is clear up to `certified`.
  bool work(Index certified, std::size_t pairs) {
    check_interrupt();
    work_left_ -= static_cast<long>(pairs) + kPlacing;
    if (work_left_ < 0) contact_ = Contact{static_cast<double>(certified)};
    return work_left_ >= 0;
  }

  void touch(double sample, std::size_t p) {
    const ShapePair& pair = scene_.pairs[p];
    contact_ = {sample, scene_.shapes[index(pair.a)].body, scene_.shapes[index(pair.b)].body};
  }

  const CollisionScene& scene_;
  const GuardedScene& guarded_;
  const RowsRef& samples_;
  const Eigen::VectorXd& start_;
  double age_;
  long work_left_;
  std::vector<MovingValues> travel_;  // total variation of each moving joint after each sample
  std::vector<MovingValues> reach_;
  collision::PlacedScene placed_;
  std::vector<std::size_t> open_;  // a stack of pairs that are not certified yet
  std::optional<Contact> contact_;
  bool fine_ = true;  // all pairs left open move by more than the tolerance
};

}  // namespace

GuardedScene guarded_scene(const CollisionModel& model, const PlacedShapes& obstacles,
                           const std::vector<double>& growth, double margin,
                           double self_collision_margin) {
  const auto pieces = std::count_if(obstacles.begin(), obstacles.end(),
                                    [](const PlacedShape& placed) { return placed.piece; });
  check_argument(growth.size() + static_cast<std::size_t>(pieces) == obstacles.size(),
                 "growth: expected one for each obstacle");
  const CollisionModel own = without_meeting_pairs(model);
  GuardedScene result{whole_arm(own, obstacles, margin, self_collision_margin), {}};
  const int bodies = static_cast<int>(own.bodies.size());
  for (const ShapePair& pair : result.arm.scene.pairs) {
    const int body = result.arm.scene.shapes[index(pair.a)].body;
    result.growth.push_back(body < bodies ? 0.0 : growth[index(body - bodies)]);
  }
  return result;
}

std::optional<Contact> first_contact(const GuardedScene& scene, const Eigen::VectorXd& start,
                                     const RowsRef& samples, double age, long most_work) {
  check_rows(scene.arm.scene.chain, samples);
  check_argument(start.size() == samples.cols(), "start: expected one value a joint");
  check_argument(most_work >= 0, "most_work: expected none or more");
  return Certifier(scene, start, samples, age, most_work).run();
}

}  // namespace leadthrough::guard
