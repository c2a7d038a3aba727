#include "leadthrough/ik/swept_self_motion.hpp"

#include "leadthrough/ik/configurations.hpp"
#include "leadthrough/ik/joint_ranges.hpp"
#include "leadthrough/ik/self_motion.hpp"

namespace leadthrough {

namespace {

struct Sample {
  int index, branch;
  double distance;  // squared, from the reference, after clamping
  double outside;   // of the limits by as much, at most, before clamping, rad
  JointArray q;
};

JointRange swept_range(const Chain& chain, const ClosedForm& form) {
  if (form.parameter == Parameter::kElbow) return {0.0, kTurn};
  return sampled_range(chain, form.parameter == Parameter::kFirstJoint ? 0 : 6);
}

// Moves to the nearest limits; false if a joint is farther outside than the next sample may bring
// it.
bool bring_inside(const Chain& chain, const JointVector& reference, Sample& sample) {
  constexpr double kBetweenSamples = 0.3;  // rad
  std::array<bool, kMaxJoints> outside{};
  const JointArray before = sample.q;
  take_turns(chain, reference, sample.q, outside);
  for (int i = 0; i < chain.joints(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!outside[k]) continue;
    const double below = apart_within_turn(chain.lower[i], before[k]);
    const double above = apart_within_turn(chain.upper[i], before[k]);
    sample.q[k] = below < above ? chain.lower[i] : chain.upper[i];
    sample.outside = std::max(sample.outside, std::min(below, above));
  }
  if (sample.outside > kBetweenSamples) return false;
  const Eigen::Map<const Eigen::VectorXd> q(sample.q.data(), chain.joints());
  sample.distance = (q - reference).squaredNorm();
  return true;
}

// The configurations at one value of the parameter.
void add_samples(const Chain& chain, const ClosedForm& form, const IkTarget& target,
                 const JointVector& reference, double parameter, int index,
                 std::vector<Sample>& samples) {
  Walk walk;
  Candidates candidates;
  solve(form, {*target.rotation, target.position}, parameter, walk, candidates);
  for (int k = 0; k < candidates.count; ++k) {
    const Candidate& candidate = candidates.at[static_cast<std::size_t>(k)];
    Sample sample{index, candidate.branch, 0.0, 0.0, candidate.q};
    if (bring_inside(chain, reference, sample)) samples.push_back(sample);
  }
}

std::vector<Sample> sweep(const Chain& chain, const ClosedForm& form, const IkTarget& target,
                          const JointVector& reference) {
  const auto [lower, upper] = swept_range(chain, form);
  std::vector<Sample> samples;
  samples.reserve(8 * (kSweepSamples + 1));
  for (int index = 0; index <= kSweepSamples; ++index) {
    const double parameter = lower + (upper - lower) * index / kSweepSamples;
    add_samples(chain, form, target, reference, parameter, index, samples);
  }
  return samples;
}

// Those that are less outside than their neighbours on the branch, or as little and nearer; nearest
// first. A range inside the limits that is narrower than the steps has a sample beside it.
std::vector<Sample> nearest_of_branches(const std::vector<Sample>& samples) {
  std::vector<Sample> nearest;
  for (const Sample& sample : samples) {
    const auto beats = [&](const Sample& other) {
      return other.branch == sample.branch && std::abs(other.index - sample.index) == 1 &&
             std::pair(other.outside, other.distance) < std::pair(sample.outside, sample.distance);
    };
    if (std::none_of(samples.begin(), samples.end(), beats)) nearest.push_back(sample);
  }
  std::sort(nearest.begin(), nearest.end(),
            [](const Sample& a, const Sample& b) { return a.distance < b.distance; });
  return nearest;
}

// Halving steps of the parameter from a sample inside the limits, within its branch.
JointArray refine(const Chain& chain, const ClosedForm& form, const IkTarget& target,
                  const JointVector& reference, Sample best) {
  constexpr double kLastStep = 1e-6;  // rad
  const auto [lower, upper] = swept_range(chain, form);
  double step = (upper - lower) / kSweepSamples;
  double parameter = lower + step * best.index;
  std::vector<Sample> trials;
  trials.reserve(16);
  for (double side = 0.5; step > kLastStep; side = -side) {
    const double trial = std::clamp(parameter + side * step, lower, upper);
    trials.clear();
    add_samples(chain, form, target, reference, trial, best.index, trials);
    const auto nearer = std::find_if(trials.begin(), trials.end(), [&](const Sample& each) {
      return each.branch == best.branch && each.outside == 0.0 && each.distance < best.distance;
    });
    if (nearer != trials.end()) {
      best = *nearer, parameter = trial, side = -side;
    } else if (side < 0.0) {
      step *= 0.5;
    }
  }
  return best.q;
}

}  // namespace

double sweep_resolution(const Chain& chain, const ClosedForm& form) {
  const auto [lower, upper] = swept_range(chain, form);
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
  const auto nearer = [&](const IkResult& a, const IkResult& b) {
    return distance(a) < distance(b);
  };
  std::stable_sort(found.begin(), found.end(), nearer);
  // A descent that limits or a singularity stopped leaves samples that are nearer.
  const auto inside = std::find_if(nearest.begin(), nearest.end(),
                                   [](const Sample& sample) { return sample.outside == 0.0; });
  if (inside != nearest.end() && (found.empty() || inside->distance < distance(found.front()))) {
    const JointArray q = refine(chain, form, target, reference, *inside);
    const PoseDescent<6> there(chain, target, bounds, q);
    if (there.task().within(tolerance))
      found.insert(found.begin(),
                   result_at(q, chain.joints(), there.task(), IkStatus::kConverged, 0));
  }
  return found;
}

}  // namespace leadthrough
