#include "leadthrough/ik/configurations.hpp"

#include "leadthrough/ik/free_angles.hpp"
#include "leadthrough/ik/joint_ranges.hpp"
#include "leadthrough/ik/pose_descent.hpp"

namespace leadthrough {

namespace {

// Of the real arm's tip: m and rad, below any tolerance and above rounding.
constexpr IkTolerance kPolished{1e-9, 1e-9};
constexpr int kPolishSteps = 60;
// Configurations that differ by less, rad, are one that rounding or polishing has doubled.
constexpr double kSame = 1e-6;

// Twice the largest error of a tangent that forward kinematics could accept.
constexpr double kSlack = 2e-6;
// Sets go on beside the tangents at their ends.
constexpr double kSlackOfSets = 1e-10;
// Errors of the equations of an arm that deviates, in units of the deviation: of solutions that
// are tried, and of those beside which others may be missing.
constexpr double kTried = 4.0, kUncertain = 12.0;

class Enumeration {
 public:
  Enumeration(const Chain& chain, const ClosedForm& form, const IkTarget& target,
              const JointVector& reference, const IkTolerance& tolerance)
      : chain_(chain),
        form_(form),
        target_(target),
        reference_(reference),
        tolerance_(tolerance),
        limits_(position_limits(chain)) {
    open_.lower.fill(-kInfinity);
    open_.upper.fill(kInfinity);
    result_.found.reserve(8);
  }

  Configurations run() {
    Walk walk = new_walk(kSlack);
    Candidates candidates;
    leadthrough::solve(form_, {*target_.rotation, target_.position}, 0.0, walk, candidates);
    for (int k = 0; k < candidates.count; ++k) add(candidates.at[static_cast<std::size_t>(k)].q);
    for (int free = 1; free <= std::min(walk.free, 2); ++free)
      for (const JointArray& q :
           nearest_members(chain_, form_, target_, reference_, new_walk(kSlackOfSets), free))
        add(q);
    result_.uncertain = !form_.exact() && (walk.near || walk.free > 0 || missed_);
    if (!result_.found.empty()) result_.status = IkStatus::kConverged;
    return std::move(result_);
  }

 private:
  Walk new_walk(double slack) const {
    Walk walk;
    walk.slack = slack;
    if (form_.exact()) return walk;
    walk.slack += kTried * form_.deviation;
    walk.margin = kUncertain * form_.deviation;
    return walk;
  }

  // Keeps a configuration of the ideal arm if the real one has it.
  void add(const JointArray& ideal) {
    JointArray q = ideal;
    if (!take_turns(chain_, reference_, q).any_outside && insert_near(q)) return;
    PoseDescent<6> descent(chain_, target_, open_, ideal);
    if (!descent.task().within(kPolished)) descent.run(kPolished, kPolishSteps);
    if (!descent.task().within(tolerance_)) {
      missed_ = true;
      return;
    }
    q = descent.q();
    const Turns turns = take_turns(chain_, reference_, q);
    if (!turns.any_outside && insert_near(q)) return;
    if (result_.status != IkStatus::kLimits)
      result_.limiting = turns.any_outside ? turns.outside : turns.clamped;
    result_.status = IkStatus::kLimits;
  }

  bool insert_near(const JointArray& q) {
    PoseDescent<6> inside(chain_, target_, limits_, q);
    if (!inside.task().within(kPolished)) inside.run(kPolished, kPolishSteps);
    if (!inside.task().within(tolerance_)) return false;
    insert(inside.q(), inside.task());
    return true;
  }

  void insert(const JointArray& q, const Task<6>& task) {
    const Eigen::Map<const Eigen::VectorXd> values(q.data(), chain_.joints());
    const auto same = [&](const IkResult& other) {
      for (int i = 0; i < chain_.joints(); ++i)
        if (apart_within_turn(values[i], other.q[i]) > kSame) return false;
      return true;
    };
    auto& found = result_.found;
    const double distance = (values - reference_).squaredNorm();
    // Of two that a limit at pi sets apart by a turn, the nearer one stays.
    if (const auto other = std::find_if(found.begin(), found.end(), same); other != found.end()) {
      missed_ = true;
      if ((other->q - reference_).squaredNorm() <= distance) return;
      found.erase(other);
    }
    const auto place = std::find_if(found.begin(), found.end(), [&](const IkResult& other) {
      return (other.q - reference_).squaredNorm() > distance;
    });
    found.insert(place, result_at(q, chain_.joints(), task, IkStatus::kConverged, 0));
  }

  const Chain& chain_;
  const ClosedForm& form_;
  const IkTarget& target_;
  const JointVector& reference_;
  IkTolerance tolerance_;
  JointBox open_{}, limits_;
  Configurations result_;
  bool missed_ = false;  // a candidate came to rest away from the target, or on another one
};

}  // namespace

bool applies(const ClosedForm* form, const IkTarget& target, const IkOptions& options) {
  return form != nullptr && form->parameter == Parameter::kNone && target.rotation && !options.axes;
}

Turns take_turns(const Chain& chain, const JointVector& reference, JointArray& q) {
  Turns turns;
  for (int i = 0; i < chain.joints(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double lower = chain.lower[i], upper = chain.upper[i];
    double angle = q[k] + kTurn * std::nearbyint((reference[i] - q[k]) / kTurn);
    if (angle < lower - kBesideLimit)
      angle += kTurn * std::ceil((lower - kBesideLimit - angle) / kTurn);
    else if (angle > upper + kBesideLimit)
      angle -= kTurn * std::ceil((angle - upper - kBesideLimit) / kTurn);
    turns.outside[k] = angle < lower - kBesideLimit || angle > upper + kBesideLimit;
    q[k] = std::clamp(angle, lower, upper);
    turns.clamped[k] = q[k] != angle;
    turns.any_outside |= turns.outside[k];
  }
  return turns;
}

double bring_inside(const Chain& chain, const JointVector& reference, JointArray& q) {
  const JointArray before = q;
  const Turns turns = take_turns(chain, reference, q);
  double most = 0.0;
  for (int i = 0; turns.any_outside && i < chain.joints(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!turns.outside[k]) continue;
    const double below = apart_within_turn(chain.lower[i], before[k]);
    const double above = apart_within_turn(chain.upper[i], before[k]);
    q[k] = below < above ? chain.lower[i] : chain.upper[i];
    most = std::max(most, std::min(below, above));
  }
  return most;
}

Configurations all_configurations(const Chain& chain, const ClosedForm& form,
                                  const IkTarget& target, const JointVector& reference,
                                  const IkTolerance& tolerance) {
  return Enumeration(chain, form, target, reference, tolerance).run();
}

}  // namespace leadthrough
