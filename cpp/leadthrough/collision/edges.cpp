#include "leadthrough/collision/edges.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/base/parallel.hpp"
#include "leadthrough/collision/lane_balls.hpp"
#include "leadthrough/collision/motion_bound.hpp"

namespace leadthrough {

namespace {

using lanes::Values;

// Balls stand out of their bodies: segments in which nothing moves farther, m, are left to exact
// distances.
constexpr float kFineMotion = 0.03F;
// Closer to its margin than this, m, no pair may move that is not certified.
constexpr double kFinest = 1e-4;
// Bisections of an edge before a pair counts as too near.
constexpr int kMaxHalvings = 20;
constexpr std::size_t kLanes = lanes::kCount;
// Fewer configurations take less time than the balls take to be made ready.
constexpr Eigen::Index kWorthBalls = 64;

}  // namespace

class EdgeTest::Search {
 public:
  explicit Search(const WholeArm& arm)
      : arm_(arm),
        chain_(arm.scene.chain),
        balls_(arm),
        all_pairs_(arm.scene.pairs.size()),
        extent_(collision::sampled_extent(chain_)),
        reach_(collision::reaches(arm.scene, extent_)),
        normals_(arm.scene.pairs.size(), Eigen::Vector3d::UnitX()) {
    std::iota(all_pairs_.begin(), all_pairs_.end(), std::size_t{0});
  }

  bool clear(const double* q, const double* end) {
    set_edge(q, end);
    open_ = all_pairs_;
    near_.clear();
    middles_.clear();
    half_ = 0.5F / static_cast<float>(kLanes);
    for (std::size_t i = 0; i < kLanes; ++i)
      middles_.push_back((2.0F * static_cast<float>(i) + 1.0F) * half_);
    if (balls_.set_edge(start_, end_)) {
      for (bool first_look = true;; first_look = false) {
        test_middles(first_look);
        if (middles_.empty()) break;
        if (first_look && !middles_clear()) return false;
        if (half_ * balls_.longest_motion() < kFineMotion) break;
        halve();
      }
    }
    const std::size_t count = open_.size();
    const bool far = std::all_of(middles_.begin(), middles_.end(), [&](float middle) {
      return within(middle - half_, middle + half_, 0, count, kMaxHalvings);
    });
    open_.swap(near_);
    return far && (open_.empty() || within(0.0, 1.0, 0, open_.size(), kMaxHalvings));
  }

  unsigned clear_rows(const double* q, int count) {
    const auto joints = index(chain_.joints());
    set_edge(q, q);
    bool exact = false;
    LaneBalls::Joints values{};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      MovingValues room;
      const double* row = q + joints * std::min(lane, index(count - 1));
      const double* own = moving_values(chain_, row, room);
      std::copy_n(own, moving_count(chain_), start_.begin());
      exact = exact || !balls_.set_edge(start_, start_);
      for (std::size_t k = 0; k < moving_count(chain_); ++k)
        values.value[k][static_cast<int>(lane)] = static_cast<float>(own[k]);
    }
    if (exact)
      passed_.assign(all_pairs_.size(), 0);
    else
      balls_.test(values, 0.0F, all_pairs_, passed_);
    unsigned every = ~0U;
    for (const LaneBalls::Passed& each : passed_) every &= each;
    for (int i = 0; i < count; ++i)
      if (!(every >> i & 1U) && row_clear(q + joints * index(i), i)) every |= 1U << i;
    return every & ((1U << count) - 1U);
  }

 private:
  void set_edge(const double* q, const double* end) {
    MovingValues room;
    std::copy_n(moving_values(chain_, q, room), moving_count(chain_), start_.begin());
    std::copy_n(moving_values(chain_, end, room), moving_count(chain_), end_.begin());
    bool farther = false;
    for (std::size_t k = 0; k < moving_count(chain_); ++k) {
      const double most = std::max(std::abs(start_[k]), std::abs(end_[k]));
      farther = farther || most > extent_[k];
      extent_[k] = std::max(extent_[k], most);
    }
    if (farther) reach_ = collision::reaches(arm_.scene, extent_);
  }

  // Keeps the middles and the pairs that are not certified. Pairs that are near all along the edge
  // are set aside.
  void test_middles(bool first_look) {
    open_marks_.assign(open_.size(), false);
    kept_.clear();
    for (std::size_t first = 0; first < middles_.size(); first += kLanes) {
      const std::size_t count = std::min(kLanes, middles_.size() - first);
      LaneBalls::Joints values;
      for (std::size_t k = 0; k < moving_count(chain_); ++k) {
        const auto start = static_cast<float>(start_[k]);
        const auto change = static_cast<float>(end_[k] - start_[k]);
        for (std::size_t lane = 0; lane < kLanes; ++lane)
          values.value[k][static_cast<int>(lane)] =
              start + middles_[first + std::min(lane, count - 1)] * change;
      }
      balls_.test(values, half_, open_, passed_);
      unsigned every = ~0U;
      for (std::size_t i = 0; i < open_.size(); ++i) {
        if (passed_[i] == 0 && first_look) {
          near_.push_back(open_[i]);
          continue;
        }
        every &= passed_[i];
        if (passed_[i] != 0xFF) open_marks_[i] = true;
      }
      for (std::size_t lane = 0; lane < count; ++lane)
        if (!(every >> lane & 1U)) kept_.push_back(middles_[first + lane]);
    }
    middles_.swap(kept_);
    std::size_t left = 0;
    for (std::size_t i = 0; i < open_.size(); ++i)
      if (open_marks_[i]) open_[left++] = open_[i];
    open_.resize(left);
  }

  // The pairs that are left, at the middles themselves; the last first, as edges of trees begin at
  // what is known to be clear.
  bool middles_clear() {
    return std::all_of(middles_.rbegin(), middles_.rend(), [&](float middle) {
      check_interrupt();
      move_to(middle);
      return std::all_of(open_.begin(), open_.end(),
                         [&](std::size_t p) { return apart(p, arm_.margins[p] - kTouching); });
    });
  }

  void halve() {
    kept_.clear();
    half_ *= 0.5F;
    for (const float middle : middles_) {
      kept_.push_back(middle - half_);
      kept_.push_back(middle + half_);
    }
    middles_.swap(kept_);
  }

  bool row_clear(const double* q, int bit) {
    set_edge(q, q);
    move_to(0.0);
    for (std::size_t p = 0; p < passed_.size(); ++p)
      if (!(passed_[p] >> bit & 1U) && !apart(p, arm_.margins[p] - kTouching)) return false;
    return true;
  }

  // Exact distances certify the pairs open_[first, end) from one fraction of the edge to another.
  bool within(double from, double to, std::size_t first, std::size_t end, int halvings) {
    check_interrupt();
    const double middle = 0.5 * (from + to);
    move_to(middle);
    const std::size_t left = open_.size();
    MovingValues change{};
    for (std::size_t k = 0; k < moving_count(chain_); ++k)
      change[k] = (to - middle) * std::abs(end_[k] - start_[k]);
    bool certified = true;
    for (std::size_t i = first; i < end && certified; ++i) {
      const std::size_t p = open_[i];
      const double least = arm_.margins[p] - kTouching;
      const double motion = collision::pair_motion(arm_.scene, reach_, arm_.scene.pairs[p], change);
      if (apart(p, least + motion)) continue;
      certified = halvings > 0 && motion > kFinest && apart(p, least);
      open_.push_back(p);
    }
    const std::size_t right = open_.size();
    if (certified && right > left)
      certified = within(from, middle, left, right, halvings - 1) &&
                  within(middle, to, left, right, halvings - 1);
    open_.resize(left);
    return certified;
  }

  void move_to(double fraction) {
    MovingValues values;
    for (std::size_t k = 0; k < moving_count(chain_); ++k)
      values[k] = (1.0 - fraction) * start_[k] + fraction * end_[k];
    collision::joint_frames(chain_, values.data(), frames_);
  }

  bool apart(std::size_t p, double least) {
    const ShapePair& pair = arm_.scene.pairs[p];
    const auto& shapes = arm_.scene.shapes;
    const BodyShape &a = shapes[index(pair.a)], &b = shapes[index(pair.b)];
    const Transform A = pose(index(pair.a)), B = pose(index(pair.b));
    return collision::ball_distance(a, A, b, B) >= least ||
           collision::apart(a, A, b, B, least, normals_[p]);
  }

  Transform pose(std::size_t shape) const {
    const Transform& own = arm_.scene.shapes[shape].T_frame_shape;
    const int frame = arm_.scene.frames[shape];
    return frame > 0 ? frames_[index(frame)] * own : own;
  }

  const WholeArm& arm_;
  const Chain& chain_;
  LaneBalls balls_;
  std::vector<std::size_t> all_pairs_;
  MovingValues start_{}, end_{};
  // Segments of the edge that are not certified, and the pairs.
  std::vector<float> middles_, kept_;
  float half_ = 0.0F;
  std::vector<std::size_t> open_, near_;
  std::vector<bool> open_marks_;
  std::vector<LaneBalls::Passed> passed_;
  // For exact distances.
  MovingValues extent_;  // within which the reaches hold
  std::vector<MovingValues> reach_;
  std::vector<Eigen::Vector3d> normals_;
  collision::Frames frames_;
};

EdgeTest::EdgeTest(const WholeArm& arm) : search_(std::make_unique<Search>(arm)) {}
EdgeTest::~EdgeTest() = default;

bool EdgeTest::clear(const double* q, const double* end) { return search_->clear(q, end); }

unsigned EdgeTest::clear_rows(const double* q, int count) { return search_->clear_rows(q, count); }

std::vector<bool> clear_batch(const WholeArm& arm, const RowsRef& q) {
  check_rows(arm.scene.chain, q);
  std::vector<bool> clear;
  if (q.rows() < kWorthBalls) {
    ClearanceTest test(arm);
    for (Eigen::Index i = 0; i < q.rows(); ++i) clear.push_back(test.clear(q.row(i).data()));
    return clear;
  }
  EdgeTest test(arm);
  constexpr auto kRows = static_cast<Eigen::Index>(kLanes);
  for (Eigen::Index first = 0; first < q.rows(); first += kRows) {
    check_interrupt();
    const auto count = static_cast<int>(std::min(kRows, q.rows() - first));
    const unsigned flags = test.clear_rows(q.row(first).data(), count);
    for (int i = 0; i < count; ++i) clear.push_back((flags >> i & 1U) != 0);
  }
  return clear;
}

std::vector<bool> clear_edges(const WholeArm& arm, const RowsRef& starts, const RowsRef& ends,
                              int threads) {
  constexpr Eigen::Index kTogether = 64;  // edges
  check_rows(arm.scene.chain, starts);
  check_rows(arm.scene.chain, ends);
  check_argument(ends.rows() == starts.rows(), "ends: expected one for each start");
  std::vector<std::uint8_t> clear(index(starts.rows()));
  for_each_block(starts.rows(), kTogether, threads, [&](Eigen::Index first, Eigen::Index end) {
    EdgeTest test(arm);
    for (Eigen::Index i = first; i < end; ++i)
      clear[index(i)] = test.clear(starts.row(i).data(), ends.row(i).data());
  });
  return {clear.begin(), clear.end()};
}

}  // namespace leadthrough
