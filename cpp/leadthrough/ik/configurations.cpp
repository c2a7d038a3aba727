#include "leadthrough/ik/configurations.hpp"

#include <numeric>

#include "leadthrough/ik/joint_ranges.hpp"
#include "leadthrough/ik/pose_descent.hpp"

namespace leadthrough {

namespace {

// Of the real arm's tip: m and rad, below any tolerance and above rounding.
constexpr IkTolerance kPolished{1e-9, 1e-9};
constexpr int kPolishSteps = 60;
// Configurations that differ by less, rad, are one that rounding or polishing has doubled.
constexpr double kSame = 1e-6;
// Angles inside the limits but for rounding, rad.
constexpr double kAtLimit = 1e-9;

// Twice the largest error of a tangent that forward kinematics could accept.
constexpr double kSlack = 2e-6;
// Errors of the equations of an arm that deviates, in units of the deviation: of solutions that
// are tried, and of those beside which others may be missing.
constexpr double kTried = 4.0, kUncertain = 12.0;

class Enumeration {
 public:
  Enumeration(const Chain& chain, const ClosedForm& form, const IkTarget& target,
              const JointVector& reference, const IkTolerance& tolerance)
      : chain_(chain), form_(form), target_(target), reference_(reference), tolerance_(tolerance) {
    open_.lower.fill(-kInfinity);
    open_.upper.fill(kInfinity);
    result_.found.reserve(8);
  }

  Configurations run() {
    Walk walk = new_walk();
    Candidates candidates;
    leadthrough::solve(form_, {*target_.rotation, target_.position}, 0.0, walk, candidates);
    for (int k = 0; k < candidates.count; ++k) add(candidates.at[static_cast<std::size_t>(k)].q);
    for (int free = 1; free <= std::min(walk.free, 2); ++free) sweep(free);
    result_.uncertain = !form_.exact() && (walk.near || walk.free > 0 || missed_);
    if (!result_.found.empty()) result_.status = IkStatus::kConverged;
    return std::move(result_);
  }

 private:
  static constexpr std::size_t kBranches = 32;
  // Values of one free angle, and of each of two.
  static constexpr int kSamples = 64, kSamplesOfTwo = 24;
  using Free = std::array<double, 2>;
  // Of each branch: squared distance from the reference, infinite outside the limits, and whether
  // it is there without them.
  struct Sample {
    std::array<double, kBranches> distance;
    std::array<bool, kBranches> exists;
  };

  Walk new_walk() const {
    Walk walk;
    walk.slack = kSlack;
    if (form_.exact()) return walk;
    walk.slack += kTried * form_.deviation;
    walk.margin = kUncertain * form_.deviation;
    return walk;
  }

  // Keeps a configuration of the ideal arm if the real one has it.
  void add(JointArray q) {
    PoseDescent<6> descent(chain_, target_, open_, q);
    if (!descent.task().within(kPolished)) {
      descent.run(kPolished, kPolishSteps);
      q = descent.q();
    }
    if (!descent.task().within(tolerance_)) {
      missed_ = true;
      return;
    }
    std::array<bool, kMaxJoints> outside{};
    if (take_turns(chain_, reference_, q, outside) == 0) return insert(q, descent.task());
    if (result_.status != IkStatus::kLimits) result_.limiting = outside;
    result_.status = IkStatus::kLimits;
  }

  void insert(const JointArray& q, const Task<6>& task) {
    const Eigen::Map<const Eigen::VectorXd> values(q.data(), chain_.joints());
    const auto same = [&](const IkResult& other) {
      for (int i = 0; i < chain_.joints(); ++i)
        if (apart_within_turn(values[i], other.q[i]) > kSame) return false;
      return true;
    };
    auto& found = result_.found;
    if (std::any_of(found.begin(), found.end(), same)) {
      missed_ = true;
      return;
    }
    const double distance = (values - reference_).squaredNorm();
    const auto place = std::find_if(found.begin(), found.end(), [&](const IkResult& other) {
      return (other.q - reference_).squaredNorm() > distance;
    });
    found.insert(place, result_at(q, chain_.joints(), task, IkStatus::kConverged, 0));
  }

  Candidates with_free(int free, const Free& values) const {
    Walk walk = new_walk();
    walk.given = free;
    for (std::size_t k = 0; k < 2; ++k) walk.values[k] = {std::cos(values[k]), std::sin(values[k])};
    Candidates candidates;
    leadthrough::solve(form_, {*target_.rotation, target_.position}, 0.0, walk, candidates);
    return candidates;
  }

  double squared_distance(JointArray q) const {
    std::array<bool, kMaxJoints> outside{};
    if (take_turns(chain_, reference_, q, outside) > 0) return kInfinity;
    const Eigen::Map<const Eigen::VectorXd> values(q.data(), chain_.joints());
    return (values - reference_).squaredNorm();
  }

  Sample sample(int free, const Free& values) const {
    Sample sample;
    sample.distance.fill(kInfinity);
    sample.exists.fill(false);
    const Candidates candidates = with_free(free, values);
    for (int k = 0; k < candidates.count; ++k) {
      const Candidate& candidate = candidates.at[static_cast<std::size_t>(k)];
      const auto branch = static_cast<std::size_t>(candidate.branch);
      sample.exists[branch] = true;
      sample.distance[branch] = squared_distance(candidate.q);
    }
    return sample;
  }

  // The members nearest to the reference of all sets with so many free angles.
  void sweep(int free) {
    const int side = free == 1 ? kSamples : kSamplesOfTwo, count = free == 1 ? side : side * side;
    const auto at = [&](int k) {
      return Free{kTurn * (k % side) / side, kTurn * static_cast<int>(k / side) / side};
    };
    std::vector<Sample> samples;
    for (int k = 0; k < count; ++k) samples.push_back(sample(free, at(k)));
    const std::vector<std::size_t> sets = connected(samples, free == 1);
    std::vector<std::size_t> nearest(sets.size(), sets.size());
    const auto distance = [&](std::size_t node) {
      return samples[node / kBranches].distance[node % kBranches];
    };
    for (std::size_t node = 0; node < sets.size(); ++node) {
      std::size_t& best = nearest[sets[node]];
      if (distance(node) < kInfinity && (best == sets.size() || distance(node) < distance(best)))
        best = node;
    }
    for (const std::size_t node : nearest)
      if (node < sets.size())
        add_nearest(free, at(static_cast<int>(node / kBranches)), kTurn / side, node % kBranches);
  }

  // The set of each sample's branches: neighbours of one branch are connected, and two branches
  // where they end together. Without neighbours, each branch is a set.
  std::vector<std::size_t> connected(const std::vector<Sample>& samples, bool neighbours) const {
    std::vector<std::size_t> sets(samples.size() * kBranches);
    std::iota(sets.begin(), sets.end(), std::size_t{0});
    const auto root = [&](std::size_t node) {
      while (sets[node] != node) node = sets[node] = sets[sets[node]];
      return node;
    };
    const auto join = [&](std::size_t a, std::size_t b) { sets[root(a)] = root(b); };
    for (std::size_t k = 0; k < samples.size(); ++k) {
      const std::size_t next = (k + 1) % samples.size();
      const auto inside = [&](std::size_t i, std::size_t branch) {
        return samples[i].distance[branch] < kInfinity;
      };
      for (std::size_t branch = 0; branch < kBranches; ++branch) {
        if (!neighbours) {
          join(k * kBranches + branch, branch);
          continue;
        }
        if (inside(k, branch) && inside(next, branch))
          join(k * kBranches + branch, next * kBranches + branch);
        for (std::size_t bit = 1; bit < kBranches; bit *= 2) {
          const std::size_t other = branch ^ bit;
          const auto ends = [&](std::size_t here, std::size_t there) {
            return inside(here, branch) && inside(here, other) && !samples[there].exists[branch] &&
                   !samples[there].exists[other];
          };
          if (ends(k, next)) join(k * kBranches + branch, k * kBranches + other);
          if (ends(next, k)) join(next * kBranches + branch, next * kBranches + other);
        }
      }
    }
    for (std::size_t node = 0; node < sets.size(); ++node) sets[node] = root(node);
    return sets;
  }

  // Compass search from a sample, within its branch.
  void add_nearest(int free, Free values, double step, std::size_t branch) {
    constexpr double kLastStep = 1e-8;  // rad
    double least = sample(free, values).distance[branch];
    while (step > kLastStep) {
      bool moved = false;
      for (int k = 0; k < 2 * free && !moved; ++k) {
        Free trial = values;
        trial[static_cast<std::size_t>(k / 2)] += k % 2 == 0 ? step : -step;
        const double distance = sample(free, trial).distance[branch];
        if (!(distance < least)) continue;
        least = distance, values = trial, moved = true;
      }
      if (!moved) step *= 0.5;
    }
    const Candidates candidates = with_free(free, values);
    for (int k = 0; k < candidates.count; ++k) {
      const Candidate& candidate = candidates.at[static_cast<std::size_t>(k)];
      if (static_cast<std::size_t>(candidate.branch) == branch) add(candidate.q);
    }
  }

  const Chain& chain_;
  const ClosedForm& form_;
  const IkTarget& target_;
  const JointVector& reference_;
  IkTolerance tolerance_;
  JointBox open_{};
  Configurations result_;
  bool missed_ = false;  // a candidate came to rest away from the target, or on another one
};

}  // namespace

bool applies(const ClosedForm* form, const IkTarget& target, const IkOptions& options) {
  return form != nullptr && form->parameter == Parameter::kNone && target.rotation && !options.axes;
}

int take_turns(const Chain& chain, const JointVector& reference, JointArray& q,
               std::array<bool, kMaxJoints>& outside) {
  int count = 0;
  for (int i = 0; i < chain.joints(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double lower = chain.lower[i], upper = chain.upper[i];
    double angle = q[k] + kTurn * std::nearbyint((reference[i] - q[k]) / kTurn);
    if (angle < lower - kAtLimit)
      angle += kTurn * std::ceil((lower - kAtLimit - angle) / kTurn);
    else if (angle > upper + kAtLimit)
      angle -= kTurn * std::ceil((angle - upper - kAtLimit) / kTurn);
    outside[k] = angle < lower - kAtLimit || angle > upper + kAtLimit;
    count += outside[k] ? 1 : 0;
    q[k] = std::clamp(angle, lower, upper);
  }
  return count;
}

Configurations all_configurations(const Chain& chain, const ClosedForm& form,
                                  const IkTarget& target, const JointVector& reference,
                                  const IkTolerance& tolerance) {
  return Enumeration(chain, form, target, reference, tolerance).run();
}

}  // namespace leadthrough
