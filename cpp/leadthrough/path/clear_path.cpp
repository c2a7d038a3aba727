#include "leadthrough/path/clear_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/path/refine.hpp"

namespace leadthrough::path {

namespace {

constexpr int kMaxKnots = 160;
constexpr int kRounds = 8;
constexpr double kMinRoom = 0.001;  // m beyond the margins that the refinement aims at
constexpr double kWide = 0.004;     // m beyond the margins, of a path that is not narrow
constexpr double kMoreRoom = 5e-4;  // m beyond a round's missing clearance
// Of the certificate, m: in most rounds, and in the last ones, which lack little clearance.
constexpr double kExactness = 2e-4, kGreatExactness = 2e-5;
constexpr int kLastRounds = 2;
constexpr Eigen::Index kMaxParts = 32;  // that a sample's interval is checked in
constexpr double kAstray = 0.3;         // rad or m, largest distance of a sample from the curve

class Search {
 public:
  Search(const CollisionModel& model, const PlacedShapes& obstacles, const TipPath& path,
         const RowsRef& postures, const Margins& margins, const IkTolerance& tolerance)
      : chain_(model.chain),
        path_(path),
        postures_(postures),
        tolerance_(tolerance),
        margins_(margins),
        scenes_{against(model, obstacles), itself(model)},
        arm_(whole_arm(model, obstacles, margins.obstacles, margins.itself)),
        test_(arm_) {}

  ClearPath run(const std::optional<JointArray>& start, int max_attempts) {
    ClearPath result;
    bool was_narrow = false;
    // After a failed search the next is finer and covers all branches. A path that cannot be
    // refined collision-free is narrow: the next has more room, if there is one.
    struct Effort {
      std::size_t width;
      double cell;
      double layers;  // spacing of layers relative to the nominal one
      bool of_every_family;
    };
    constexpr std::array<Effort, kMaxAttempts> kEfforts{
        {{64, 0.1, 1.0, false}, {128, 0.06, 0.5, true}, {256, 0.04, 0.5, true}}};
    for (int n = 0; n < max_attempts; ++n) {
      check_interrupt();
      const Effort& effort = kEfforts[static_cast<std::size_t>(n)];
      LadderOptions options;
      options.width = effort.width;
      options.cell = effort.cell;
      options.spacing *= effort.layers;
      options.rotation_spacing *= effort.layers;
      options.of_every_family = effort.of_every_family;
      options.room = was_narrow ? kWide : 0.0;
      const Climb found = climb(chain_, path_, test_, postures_, start, options);
      result.dead_end = found.dead_end;
      if (!found.q.empty()) result.last = found.q.back();
      was_narrow = found.arrived();
      if (!found.arrived()) continue;
      const std::optional<Rows> q = smooth(found, result.touch);
      if (!q) continue;
      result.q = *q;
      return result;
    }
    return result;
  }

 private:
  // Refines until the check finds no pair nearer than the margins; `touch` is the remaining closest
  // pair.
  std::optional<Rows> smooth(const Climb& found, std::optional<ClosestPair>& touch) {
    make_knots(found);
    Rows q(path_.positions.rows(), chain_.joints());
    touch.reset();
    for (int round = 0; round < kRounds; ++round) {
      check_interrupt();
      refine(chain_, knots_, test_, arm_.margins, curve_);
      if (!all_samples(q)) return std::nullopt;
      touch = give_room(q, round < kRounds - kLastRounds ? kExactness : kGreatExactness);
      if (!touch) return q;
    }
    return std::nullopt;
  }

  void make_knots(const Climb& found) {
    const Eigen::Index rows = path_.positions.rows();
    const Eigen::Index count = std::min<Eigen::Index>(rows, kMaxKnots);
    knots_.clear();
    curve_.clear();
    samples_.clear();
    std::size_t layer = 0;
    for (Eigen::Index k = 0; k < count; ++k) {
      check_interrupt();
      const double sample = count > 1 ? static_cast<double>(rows - 1) * static_cast<double>(k) /
                                            static_cast<double>(count - 1)
                                      : 0.0;
      while (layer + 2 < found.samples.size() && found.samples[layer + 1] < sample) ++layer;
      knots_.push_back({TipTask(chain_, path_, sample), posture(sample), kMinRoom});
      curve_.push_back(between(found, layer, sample));
      samples_.push_back(sample);
    }
  }

  static JointArray between(const Climb& found, std::size_t layer, double sample) {
    if (found.samples.size() == 1) return found.q.front();
    const double from = found.samples[layer], to = found.samples[layer + 1];
    const double share = std::clamp((sample - from) / (to - from), 0.0, 1.0);
    JointArray q{};
    for (std::size_t i = 0; i < q.size(); ++i)
      q[i] = (1.0 - share) * found.q[layer][i] + share * found.q[layer + 1][i];
    return q;
  }

  JointArray posture(double sample) const {
    const auto row = std::min(static_cast<Eigen::Index>(std::lround(sample)), postures_.rows() - 1);
    JointArray result{};
    std::copy_n(postures_.row(row).data(), chain_.joints(), result.begin());
    return result;
  }

  // The configuration at each sample, on the path; false if one is not.
  bool all_samples(Rows& q) {
    constexpr double kAim = 0.1;
    const IkTolerance aim{kAim * tolerance_.position, kAim * tolerance_.orientation};
    const JointBox limits = position_limits(chain_);
    for (Eigen::Index row = 0; row < q.rows(); ++row) {
      check_interrupt();
      JointArray at = moved_in(limits, on_curve(static_cast<double>(row)), {}, chain_.joints());
      const JointBox bounds = around(at, kAstray, limits, chain_.joints());
      const TipTask task(chain_, path_, static_cast<double>(row));
      if (!task.settle(bounds, aim, at) && !task.settle(bounds, tolerance_, at)) return false;
      std::copy_n(at.begin(), chain_.joints(), q.row(row).data());
    }
    return true;
  }

  // A cubic through the knots (Catmull and Rom 1974).
  JointArray on_curve(double sample) const {
    if (curve_.size() == 1) return curve_.front();
    const double step = samples_[1];
    const std::size_t last = curve_.size() - 1;
    const std::size_t k = std::min(static_cast<std::size_t>(sample / step), last - 1);
    const double u = sample / step - static_cast<double>(k);
    if (u == 0.0) return curve_[k];
    if (u == 1.0) return curve_[k + 1];
    const JointArray& b = curve_[k];
    const JointArray& c = curve_[k + 1];
    JointArray q{};
    for (std::size_t i = 0; i < q.size(); ++i) {
      const double a = k > 0 ? curve_[k - 1][i] : 2.0 * b[i] - c[i];
      const double d = k + 2 <= last ? curve_[k + 2][i] : 2.0 * c[i] - b[i];
      const double slope_b = 0.5 * (c[i] - a), slope_c = 0.5 * (d - b[i]);
      const double v = 1.0 - u;
      q[i] = v * v * (1.0 + 2.0 * u) * b[i] + u * u * (3.0 - 2.0 * u) * c[i] +
             u * v * (v * slope_b - u * slope_c);
    }
    return q;
  }

  // Raises the room of knots where the motion comes too near; returns the closest pair, if any. A
  // controller interpolates the samples by a smooth curve: this curve is checked, on a finer grid
  // where it bulges.
  std::optional<ClosestPair> give_room(const Rows& q, double exactness) {
    std::optional<ClosestPair> touch;
    std::vector<double> more(knots_.size(), 0.0);
    for (std::size_t scene = 0; scene < scenes_.size(); ++scene) {
      check_interrupt();
      const CollisionScene& around = scenes_[scene];
      // The check's own inexactness is added.
      const double least = (scene == 0 ? margins_.obstacles : margins_.itself) + exactness;
      const double bulging = bulge(around, q);
      const auto parts = std::clamp<Eigen::Index>(
          static_cast<Eigen::Index>(std::ceil(std::sqrt(4.0 * bulging / exactness))), 1, kMaxParts);
      if (parts > 1) {
        const Rows curve = denser(q, parts);
        look_at(around, curve, parts, {least + bulge(around, curve), exactness, 1}, touch, more);
      }
      const double straight = parts > 1 ? 0.0 : bulging;
      look_at(around, q, 1, {least + straight, exactness, 1}, touch, more);
    }
    for (std::size_t k = 0; k < knots_.size(); ++k) knots_[k].room += more[k];
    return touch;
  }

  // Rows, `parts` per sample, that come too near, and their missing clearance.
  void look_at(const CollisionScene& scene, const Rows& rows, Eigen::Index parts,
               const MotionOptions& options, std::optional<ClosestPair>& touch,
               std::vector<double>& more) const {
    const MotionReport report = check_motion(scene, rows, options);
    if (!report.first) return;
    const auto per_sample = static_cast<double>(parts);
    ClosestPair closest = report.closest;
    closest.sample /= per_sample;
    if (!touch || closest.nearest.distance < touch->nearest.distance) touch = closest;
    raise(closest, options.margin, more);
    raise({report.first->nearest, report.first->sample / per_sample}, options.margin, more);
    for (std::size_t i = 0; i < report.samples.size(); ++i)
      raise({report.samples[i], static_cast<double>(i) / per_sample}, options.margin, more);
  }

  // The samples and, between them, points of a cubic through them.
  Rows denser(const Rows& q, Eigen::Index parts) const {
    Rows result((q.rows() - 1) * parts + 1, q.cols());
    for (Eigen::Index row = 0; row < result.rows(); ++row) {
      check_interrupt();
      const double u = static_cast<double>(row % parts) / static_cast<double>(parts);
      const Eigen::Index b = std::min(row / parts, q.rows() - 1);
      if (row % parts == 0) {
        result.row(row) = q.row(b);
        continue;
      }
      const Eigen::Index a = std::max<Eigen::Index>(b - 1, 0), d = std::min(b + 2, q.rows() - 1);
      const double v = 1.0 - u;
      const auto slope_b = 0.5 * (q.row(b + 1) - q.row(a));
      const auto slope_c = 0.5 * (q.row(d) - q.row(b));
      result.row(row) = v * v * (1.0 + 2.0 * u) * q.row(b) +
                        u * u * (3.0 - 2.0 * u) * q.row(b + 1) +
                        u * v * (v * slope_b - u * slope_c);
    }
    return result;
  }

  void raise(const ClosestPair& at, double needed, std::vector<double>& more) const {
    const double missing = needed - at.nearest.distance;
    if (!(missing > 0.0)) return;
    const double step = samples_.size() > 1 ? samples_[1] : 1.0;
    for (std::size_t k = 0; k < knots_.size(); ++k)
      if (std::abs(samples_[k] - at.sample) <= 1.5 * step)
        more[k] = std::max(more[k], missing + kMoreRoom);
  }

  // Bound on the deviation of any part of the arm from linear motion between two samples for a
  // smooth curve through them, m: an eighth of the second differences.
  static double bulge(const CollisionScene& scene, const Rows& q) {
    if (q.rows() < 3) return 0.0;
    Rows both = Rows::Zero(2, q.cols());
    for (Eigen::Index i = 1; i + 1 < q.rows(); ++i)
      both.row(1) =
          both.row(1).cwiseMax((q.row(i - 1) - 2.0 * q.row(i) + q.row(i + 1)).cwiseAbs() / 8.0);
    return longest_step(scene, both);
  }

  const Chain& chain_;
  const TipPath& path_;
  const RowsRef& postures_;
  IkTolerance tolerance_;
  Margins margins_;
  std::array<CollisionScene, 2> scenes_;  // obstacles, the arm itself
  WholeArm arm_;
  ClearanceTest test_;
  std::vector<Knot> knots_;
  std::vector<JointArray> curve_;
  std::vector<double> samples_;  // of the knots
};

}  // namespace

ClearPath find_clear_path(const CollisionModel& model, const PlacedShapes& obstacles,
                          const TipPath& path, const RowsRef& postures,
                          const std::optional<JointArray>& start, const Margins& margins,
                          const IkTolerance& tolerance, int max_attempts) {
  const Eigen::Index samples = path.positions.rows();
  check_argument(samples > 0 && (path.positions.array().abs() < kTooFar).all(),
                 "positions: expected numbers below 1e100");
  check_argument((path.orientations.rows() == samples || path.orientations.rows() == 0) &&
                     (path.orientations.array().abs() < kTooFar).all(),
                 "orientations: expected a finite row for each position, or none");
  check_argument(postures.rows() == samples && postures.cols() == model.chain.joints(),
                 "postures: expected a row for each position and one value a joint");
  check_argument(path.tube.cols() == 6 &&
                     (path.tube.rows() == 0 || (path.tube.rows() == 6 * samples && path.axes)),
                 "tube: expected six rows for each position, with axes, or none");
  check_argument(max_attempts >= 1 && max_attempts <= kMaxAttempts,
                 "max_attempts: expected 1 to kMaxAttempts");
  return Search(model, obstacles, path, postures, margins, tolerance).run(start, max_attempts);
}

}  // namespace leadthrough::path
