#include "leadthrough/ik/swept_self_motion.hpp"

#include <limits>

#include "leadthrough/ik/configurations.hpp"
#include "leadthrough/ik/joint_ranges.hpp"
#include "leadthrough/ik/self_motion.hpp"

namespace leadthrough {

namespace {

struct Sample {
  int index, branch;  // the place of the parameter among all, in order
  double parameter;
  double distance;  // squared, from the reference, after clamping
  double outside;   // of the limits by as much, at most, before clamping, rad
  JointArray q;
};

// One turn at most: the other turns of the given joint are chosen as those of all.
JointRange swept_range(const Chain& chain, const ClosedForm& form, const JointVector& reference) {
  if (form.parameter == Parameter::kElbow) return {0.0, kTurn};
  const int joint = form.parameter == Parameter::kFirstJoint ? 0 : 6;
  const auto [lower, upper] = sampled_range(chain, joint);
  if (upper - lower <= kTurn) return {lower, upper};
  return {reference[joint] - 0.5 * kTurn, reference[joint] + 0.5 * kTurn};
}

struct Slice {
  double parameter;
  Candidates candidates;
};

// The configurations at values of the parameter, in order.
class Sweep {
 public:
  Sweep(const Chain& chain, const ClosedForm& form, const IkTarget& target,
        const JointVector& reference)
      : chain_(chain), form_(form), target_(target), reference_(reference) {}

  Slice at(double parameter) {
    Slice slice{parameter, {}};
    solve(form_, {*target_.rotation, target_.position}, parameter, walk_, slice.candidates);
    return slice;
  }

  void add(const Slice& slice) {
    constexpr double kBetweenSteps = 0.3;  // rad; the next sample may be inside
    for (int k = 0; k < slice.candidates.count; ++k) {
      const Candidate& candidate = slice.candidates.at[static_cast<std::size_t>(k)];
      Sample sample{index_, candidate.branch, slice.parameter, 0.0, 0.0, candidate.q};
      sample.outside = bring_inside(chain_, reference_, sample.q);
      if (sample.outside > kBetweenSteps) continue;
      const Eigen::Map<const Eigen::VectorXd> q(sample.q.data(), chain_.joints());
      sample.distance = (q - reference_).squaredNorm();
      samples.push_back(sample);
    }
    ++index_;
  }

  // Steps are halved if a branch ends within, or joints turn far as beside a singularity.
  void add_between(const Slice& before, const Slice& after, int halvings) {
    if (halvings == 0 || near(before.candidates, after.candidates)) return;
    const Slice middle = at(0.5 * (before.parameter + after.parameter));
    add_between(before, middle, halvings - 1);
    add(middle);
    add_between(middle, after, halvings - 1);
  }

  std::vector<Sample> samples;

 private:
  static bool near(const Candidates& before, const Candidates& after) {
    if (before.count != after.count) return false;
    const auto begin = after.at.begin(), end = begin + after.count;
    return std::all_of(before.at.begin(), before.at.begin() + before.count,
                       [&](const Candidate& each) {
                         return std::any_of(begin, end, [&](const Candidate& other) {
                           return other.branch == each.branch && is_near(each.q, other.q);
                         });
                       });
  }

  static bool is_near(const JointArray& a, const JointArray& b) {
    constexpr double kNear = 0.5;  // rad
    return std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) {
      const double apart = std::abs(x - y);
      return std::min(apart, std::abs(kTurn - apart)) < kNear;
    });
  }

  const Chain& chain_;
  const ClosedForm& form_;
  const IkTarget& target_;
  const JointVector& reference_;
  Walk walk_;
  int index_ = 0;
};

std::vector<Sample> sweep(const Chain& chain, const ClosedForm& form, const IkTarget& target,
                          const JointVector& reference) {
  constexpr int kHalvings = 5;
  const auto [lower, upper] = swept_range(chain, form, reference);
  Sweep sweep(chain, form, target, reference);
  sweep.samples.reserve(8 * (kSweepSamples + 1));
  Slice before = sweep.at(lower);
  sweep.add(before);
  for (int index = 1; index <= kSweepSamples; ++index) {
    const Slice after = sweep.at(lower + (upper - lower) * index / kSweepSamples);
    sweep.add_between(before, after, kHalvings);
    sweep.add(after);
    before = after;
  }
  return std::move(sweep.samples);
}

bool better(const Sample& a, const Sample& b) {
  return std::pair(a.outside, a.distance) < std::pair(b.outside, b.distance);
}

// Whether no joint is at another turn, beyond the other limit.
bool at_the_same_turns(const Sample& a, const Sample& b) {
  return std::equal(a.q.begin(), a.q.end(), b.q.begin(),
                    [](double x, double y) { return std::abs(x - y) < 0.5 * kTurn; });
}

// Those that are less outside than their neighbours on the branch, or as little and nearer; nearest
// first. A range inside the limits that is narrower than the steps has a sample beside it.
std::vector<Sample> nearest_of_branches(const std::vector<Sample>& samples) {
  std::vector<Sample> nearest;
  for (const Sample& sample : samples) {
    const auto beats = [&](const Sample& other) {
      return other.branch == sample.branch && std::abs(other.index - sample.index) == 1 &&
             at_the_same_turns(other, sample) && better(other, sample);
    };
    if (std::none_of(samples.begin(), samples.end(), beats)) nearest.push_back(sample);
  }
  std::sort(nearest.begin(), nearest.end(),
            [](const Sample& a, const Sample& b) { return a.distance < b.distance; });
  return nearest;
}

// Halving steps of the parameter from a sample, within its branch.
JointArray refine(const Chain& chain, const ClosedForm& form, const IkTarget& target,
                  const JointVector& reference, Sample best) {
  constexpr double kLastStep = 1e-6;  // rad
  const auto [lower, upper] = swept_range(chain, form, reference);
  Sweep trials(chain, form, target, reference);
  double step = (upper - lower) / kSweepSamples;
  for (double side = 0.5; step > kLastStep; side = -side) {
    trials.samples.clear();
    trials.add(trials.at(std::clamp(best.parameter + side * step, lower, upper)));
    const auto nearer = std::find_if(
        trials.samples.begin(), trials.samples.end(),
        [&](const Sample& each) { return each.branch == best.branch && better(each, best); });
    if (nearer != trials.samples.end()) {
      best = *nearer, side = -side;
    } else if (side < 0.0) {
      step *= 0.5;
    }
  }
  return best.q;
}

}  // namespace

double sweep_resolution(const Chain& chain, const ClosedForm& form) {
  const auto [lower, upper] = swept_range(chain, form, middle(chain));
  return (upper - lower) / kSweepSamples;
}

bool sweeps(const ClosedForm* form, const IkTarget& target, const IkOptions& options) {
  return form != nullptr && form->parameter != Parameter::kNone && target.rotation && !options.axes;
}

std::vector<IkResult> swept_configurations(const Chain& chain, const ClosedForm& form,
                                           const IkTarget& target, const JointVector& reference,
                                           const IkTolerance& tolerance, int count) {
  const JointBox bounds = position_limits(chain);
  std::vector<IkResult> found;
  const std::vector<Sample> nearest = nearest_of_branches(sweep(chain, form, target, reference));
  for (const Sample& seed : nearest) {
    if (static_cast<int>(found.size()) == count) break;
    constexpr int kSteps = 200;
    SelfMotion<6, IkTarget> motion(chain, target, bounds, tolerance, seed.q);
    motion.run(towards(reference), 1.0, kSteps);
    if (!motion.task().within(tolerance)) continue;
    found.push_back(result_at(motion.q(), chain.joints(), motion.task(), IkStatus::kConverged,
                              motion.iterations()));
  }
  const auto distance = [&](const IkResult& each) { return (each.q - reference).squaredNorm(); };
  const auto sort = [&] {
    std::stable_sort(found.begin(), found.end(), [&](const IkResult& a, const IkResult& b) {
      return distance(a) < distance(b);
    });
  };
  sort();
  // A descent that limits or a singularity stopped leaves samples that are nearer.
  const double nearest_found =
      found.empty() ? std::numeric_limits<double>::infinity() : distance(found.front());
  for (const Sample& sample : nearest) {
    if (sample.distance >= nearest_found) break;
    const JointArray q = refine(chain, form, target, reference, sample);
    const PoseDescent<6> there(chain, target, bounds, q);
    if (there.task().within(tolerance))
      found.push_back(result_at(q, chain.joints(), there.task(), IkStatus::kConverged, 0));
  }
  sort();
  return found;
}

}  // namespace leadthrough
