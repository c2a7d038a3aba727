#include "leadthrough/ik/free_angles.hpp"

#include <map>
#include <numeric>

#include "leadthrough/ik/configurations.hpp"
#include "leadthrough/ik/joint_ranges.hpp"

namespace leadthrough {

namespace {

constexpr std::size_t kBranches = 32;
using Free = std::array<double, 2>;

// A branch at values of the free angles.
struct Place {
  double missed = kInfinity;    // of the equations, by as much
  double outside = kInfinity;   // of the limits, rad, and of the equations
  double distance = kInfinity;  // squared, from the reference
  JointArray q{};

  bool inside() const { return outside == 0.0; }
  bool operator<(const Place& other) const {
    return std::pair(outside, distance) < std::pair(other.outside, other.distance);
  }
};

struct FreeSample {
  Free values{};
  std::array<Place, kBranches> branches;
};

struct Member {
  Place place;
  Free values{};
  std::size_t branch = 0;
};

void take_nearer(Member& member, const Member& other) {
  if (other.place < member.place) member = other;
}

// Sets of nodes that were joined, each by one of them.
class Sets {
 public:
  explicit Sets(std::size_t count) : of_(count) { std::iota(of_.begin(), of_.end(), 0U); }
  std::size_t of(std::size_t node) {
    while (of_[node] != node) node = of_[node] = of_[of_[node]];
    return node;
  }
  void join(std::size_t a, std::size_t b) { of_[of(a)] = of(b); }

 private:
  std::vector<std::size_t> of_;
};

class FreeAngles {
 public:
  FreeAngles(const Chain& chain, const ClosedForm& form, const IkTarget& target,
             const JointVector& reference, const Walk& walk, int free)
      : chain_(chain),
        form_(form),
        target_(target),
        reference_(reference),
        walk_(walk),
        free_(free) {
    walk_.given = free;
    walk_.reach = kReach;
  }

  std::vector<JointArray> nearest_members() {
    if (free_ == 1)
      sample_circle();
    else
      sample_torus();
    Sets sets = connected();
    std::map<std::size_t, Member> nearest;  // of each set
    for (const std::size_t node : unbeaten()) take_nearer(nearest[sets.of(node)], nearest_to(node));
    std::vector<JointArray> members;
    for (const auto& [node, each] : nearest)
      if (each.place.inside()) members.push_back(each.place.q);
    return members;
  }

 private:
  static constexpr double kNear = 0.5;  // rad
  // Values of one free angle, and of each of two.
  static constexpr int kSamples = 64, kSamplesOfTwo = 24;
  static constexpr int kHalvings = 5;
  // Of samples outside, by how much the next may be less so, rad; of equations, m or unit vectors'
  // products.
  static constexpr double kBetweenSamples = 0.3, kReach = 0.05;

  Place& at(std::size_t node) { return samples_[node / kBranches].branches[node % kBranches]; }

  Member member(std::size_t node) {
    return {at(node), samples_[node / kBranches].values, node % kBranches};
  }

  FreeSample sample(const Free& values) const {
    Walk walk = walk_;
    for (std::size_t k = 0; k < 2; ++k) walk.values[k] = {std::cos(values[k]), std::sin(values[k])};
    Candidates candidates;
    solve(form_, {*target_.rotation, target_.position}, 0.0, walk, candidates);
    FreeSample sample{values, {}};
    for (int k = 0; k < candidates.count; ++k) {
      const Candidate& candidate = candidates.at[static_cast<std::size_t>(k)];
      Place& place = sample.branches[static_cast<std::size_t>(candidate.branch)];
      place.q = candidate.q;
      place.missed = candidate.missed;
      place.outside = candidate.missed + bring_inside(chain_, reference_, place.q);
      const Eigen::Map<const Eigen::VectorXd> q(place.q.data(), chain_.joints());
      place.distance = (q - reference_).squaredNorm();
    }
    return sample;
  }

  double step() const { return kTurn / (free_ == 1 ? kSamples : kSamplesOfTwo); }

  void sample_circle() {
    samples_.push_back(sample({0.0, 0.0}));
    for (int k = 1; k <= kSamples; ++k) {
      const FreeSample next = sample({step() * k, 0.0});
      add_between(FreeSample(samples_.back()), next, kHalvings);
      if (k < kSamples) samples_.push_back(next);
    }
  }

  // Steps are halved where a branch leaves the limits or ends, or joints turn far.
  void add_between(const FreeSample& before, const FreeSample& after, int halvings) {
    if (halvings == 0 || alike(before, after)) return;
    const FreeSample middle = sample({0.5 * (before.values[0] + after.values[0]), 0.0});
    add_between(before, middle, halvings - 1);
    samples_.push_back(middle);
    add_between(middle, after, halvings - 1);
  }

  bool alike(const FreeSample& a, const FreeSample& b) const {
    return std::equal(a.branches.begin(), a.branches.end(), b.branches.begin(),
                      [&](const Place& here, const Place& there) {
                        if (here.inside() != there.inside()) return false;
                        return !here.inside() || meet(here, there, kNear);
                      });
  }

  void sample_torus() {
    for (int k = 0; k < kSamplesOfTwo * kSamplesOfTwo; ++k)
      samples_.push_back(
          sample({step() * (k % kSamplesOfTwo), step() * static_cast<int>(k / kSamplesOfTwo)}));
  }

  // Whether the way from one to the next stays inside the limits and passes none by a turn, and no
  // joint turns farther.
  bool meet(const Place& a, const Place& b, double farthest = kInfinity) const {
    for (int i = 0; i < chain_.joints(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double next = b.q[k] + kTurn * std::nearbyint((a.q[k] - b.q[k]) / kTurn);
      if (next < chain_.lower[i] - kBesideLimit || next > chain_.upper[i] + kBesideLimit ||
          std::abs(next - a.q[k]) > farthest)
        return false;
    }
    return true;
  }

  std::vector<std::size_t> beside(std::size_t k) const {
    const std::size_t count = samples_.size(), side = kSamplesOfTwo;
    if (free_ == 1) return {(k + 1) % count, (k + count - 1) % count};
    const std::size_t row = k / side * side;
    return {row + (k + 1) % side, row + (k + side - 1) % side, (k + side) % count,
            (k + count - side) % count};
  }

  // Samples that are nearer than those beside them, or less outside: a set that is narrower than
  // the steps is near one of these.
  std::vector<std::size_t> unbeaten() {
    std::vector<std::size_t> nodes;
    for (std::size_t node = 0; node < samples_.size() * kBranches; ++node) {
      const Place& place = at(node);
      if (place.outside > kBetweenSamples) continue;
      const std::vector<std::size_t> others = beside(node / kBranches);
      if (std::none_of(others.begin(), others.end(), [&](std::size_t k) {
            const Place& other = at(k * kBranches + node % kBranches);
            return other < place && (!place.inside() || meet(place, other));
          }))
        nodes.push_back(node);
    }
    return nodes;
  }

  // Neighbours of one branch are connected, and two branches where they end together. Of two free
  // angles, each branch is a set.
  Sets connected() {
    Sets sets(samples_.size() * kBranches);
    for (std::size_t k = 0; k < samples_.size(); ++k) {
      const std::size_t here = k * kBranches, next = (k + 1) % samples_.size() * kBranches;
      for (std::size_t branch = 0; branch < kBranches; ++branch) {
        if (free_ == 2) {
          sets.join(here + branch, branch);
          continue;
        }
        if (at(here + branch).inside() && at(next + branch).inside() &&
            meet(at(here + branch), at(next + branch)))
          sets.join(here + branch, next + branch);
        for (std::size_t bit = 1; bit < kBranches; bit *= 2) {
          join_ends(sets, here, next, branch, branch ^ bit);
          join_ends(sets, next, here, branch, branch ^ bit);
        }
      }
    }
    return sets;
  }

  void join_ends(Sets& sets, std::size_t here, std::size_t there, std::size_t a, std::size_t b) {
    if (at(here + a).inside() && at(here + b).inside() && meet(at(here + a), at(here + b)) &&
        at(there + a).missed > 0.0 && at(there + b).missed > 0.0)
      sets.join(here + a, here + b);
  }

  // From a sample, also across where two branches meet.
  Member nearest_to(std::size_t node) {
    Member best = descended(member(node));
    for (bool crossed = true; crossed;) {
      crossed = false;
      const FreeSample there = sample(best.values);
      for (std::size_t bit = 1; bit < kBranches && !crossed; bit *= 2) {
        const std::size_t other = best.branch ^ bit;
        const Place& place = there.branches[other];
        if (!place.inside() || !meet(best.place, place, kNear)) continue;
        const Member across = descended({place, best.values, other});
        crossed = across.place < best.place;
        take_nearer(best, across);
      }
    }
    return best;
  }

  // Compass search from a sample, within its branch.
  Member descended(Member member) const {
    constexpr double kLastStep = 1e-8;  // rad
    for (double size = step(); size > kLastStep;) {
      bool moved = false;
      for (int k = 0; k < 2 * free_ && !moved; ++k) {
        Free trial = member.values;
        trial[static_cast<std::size_t>(k / 2)] += k % 2 == 0 ? size : -size;
        const Place place = sample(trial).branches[member.branch];
        if (!(place < member.place)) continue;
        member.place = place, member.values = trial, moved = true;
      }
      if (!moved) size *= 0.5;
    }
    return member;
  }

  const Chain& chain_;
  const ClosedForm& form_;
  const IkTarget& target_;
  const JointVector& reference_;
  Walk walk_;
  int free_;
  std::vector<FreeSample> samples_;
};

}  // namespace

std::vector<JointArray> nearest_members(const Chain& chain, const ClosedForm& form,
                                        const IkTarget& target, const JointVector& reference,
                                        const Walk& walk, int free) {
  return FreeAngles(chain, form, target, reference, walk, free).nearest_members();
}

}  // namespace leadthrough
