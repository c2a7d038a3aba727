#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/ik/axis_task.hpp"
#include "leadthrough/ik/configurations.hpp"
#include "leadthrough/ik/pose_search.hpp"
#include "leadthrough/ik/swept_self_motion.hpp"

namespace leadthrough {

namespace {

// More postures than any arm's finite number (16, of a general 6R chain: Primrose 1986).
constexpr int kMaxPostures = 64;
// Between solutions of a search, rad or m, by default.
constexpr double kDistinct = 0.1;
// Beside a closed form: tolerance of the search, m and rad, and distance between its solutions,
// rad.
constexpr double kExactly = 1e-9, kApart = 1e-4;

// Distinct solutions, nearest to the reference first.
class Postures {
 public:
  Postures(const Chain& chain, const JointVector& reference)
      : chain_(chain), reference_(reference) {
    found_.reserve(kMaxPostures + 1);
  }

  // Keeps the nearer one of two that are not separate.
  void add(const IkResult& result, double separation) {
    const auto nearer = [this](const IkResult& a, const IkResult& b) {
      return (a.q - reference_).squaredNorm() < (b.q - reference_).squaredNorm();
    };
    const auto alike = [&](const IkResult& other) { return same(result.q, other.q, separation); };
    const auto twin = std::find_if(found_.begin(), found_.end(), alike);
    if (twin != found_.end()) {
      if (!nearer(result, *twin)) return;
      found_.erase(std::remove_if(twin, found_.end(), alike), found_.end());
    }
    found_.insert(std::upper_bound(found_.begin(), found_.end(), result, nearer), result);
    if (found_.size() > std::size_t{kMaxPostures}) found_.pop_back();
  }

  std::vector<IkResult> take() && { return std::move(found_); }

 private:
  bool same(const JointVector& a, const JointVector& b, double separation) const {
    for (int i = 0; i < chain_.joints(); ++i) {
      const bool turns = wraps(chain_, i);
      if ((turns ? apart_within_turn(a[i], b[i]) : std::abs(a[i] - b[i])) > separation)
        return false;
    }
    return true;
  }

  const Chain& chain_;
  const JointVector& reference_;
  std::vector<IkResult> found_;
};

void search_all(const Chain& chain, const IkTarget& target, const IkOptions& options,
                const JointVector& start, const JointVector& reference, double separation,
                Postures& postures) {
  visit_target(target, options.axes, [&](auto dimension, const auto& seen) {
    constexpr int M = decltype(dimension)::value;
    PoseSearch<M, std::decay_t<decltype(seen)>> search(chain, seen, options, start, 0);
    while (search.attempt()) {
      check_interrupt();
      if (!search.found()) continue;
      search.take_turns_near(reference);
      search.approach(towards(reference), 1.0);
      postures.add(search.result(IkStatus::kConverged), separation);
    }
  });
}

// The first `count`, of which there may be more.
IkSolutions first_of(std::vector<IkResult> found, int count, bool complete) {
  IkSolutions solutions;
  solutions.found = std::move(found);
  const auto most = static_cast<std::size_t>(count);
  solutions.complete = complete && solutions.found.size() <= most;
  if (solutions.found.size() > most) solutions.found.resize(most);
  if (solutions.found.empty()) solutions.status = IkStatus::kBudget;
  return solutions;
}

// Those of a closed form, which are all different.
std::vector<IkResult> separated(const Chain& chain, const JointVector& reference,
                                std::vector<IkResult> found, double separation) {
  if (!(separation > 0.0)) return found;
  Postures postures(chain, reference);
  for (const IkResult& each : found) postures.add(each, separation);
  return std::move(postures).take();
}

// Those of a closed form that may have missed some, and what a search adds: near singularities only
// exact convergence tells solutions apart.
std::vector<IkResult> searched_exactly(const Chain& chain, const IkTarget& target,
                                       IkOptions options, const JointVector& start,
                                       const JointVector& reference, double separation,
                                       const std::vector<IkResult>& found) {
  options.tolerance.position = std::min(options.tolerance.position, kExactly);
  options.tolerance.orientation = std::min(options.tolerance.orientation, kExactly);
  Postures postures(chain, reference);
  for (const IkResult& each : found) postures.add(each, 0.0);
  search_all(chain, target, options, start, reference, separation > 0.0 ? separation : kApart,
             postures);
  return std::move(postures).take();
}

}  // namespace

IkSolutions solve_ik_all(const Chain& chain, const IkTarget& target, const VectorRef& q0,
                         const IkOptions& options, int count, double separation,
                         const ClosedForm* form) {
  check_argument(count >= 0, "count: expected none or more");
  check_options(chain, options, target.rotation.has_value());
  const JointVector start = project(chain, q0);
  const JointVector reference = options.reference.value_or(start);
  if (applies(form, target, options)) {
    Configurations all = all_configurations(chain, *form, target, reference, options.tolerance);
    if (all.uncertain)
      return first_of(
          searched_exactly(chain, target, options, start, reference, separation, all.found), count,
          false);
    IkSolutions solutions =
        first_of(separated(chain, reference, std::move(all.found), separation), count, true);
    solutions.status = all.status;
    return solutions;
  }
  Postures postures(chain, reference);
  const double apart = separation > 0.0 ? separation : kDistinct;
  if (sweeps(form, target, options)) {
    const Configurations swept =
        swept_configurations(chain, *form, target, reference, options.tolerance, kMaxPostures);
    for (const IkResult& each : swept.found) postures.add(each, apart);
    IkSolutions solutions = first_of(std::move(postures).take(), count, false);
    solutions.resolution = sweep_resolution(chain, *form);
    if (!swept.uncertain) return solutions;
  }
  search_all(chain, target, options, start, reference, apart, postures);
  return first_of(std::move(postures).take(), count, false);
}

}  // namespace leadthrough
