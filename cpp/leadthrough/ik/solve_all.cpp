#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/ik/axis_task.hpp"
#include "leadthrough/ik/pose_search.hpp"

namespace leadthrough {

namespace {

// More postures than any arm's finite number (16, of a general 6R chain: Primrose 1986).
constexpr std::size_t kMaxPostures = 64;

// Distinct solutions, nearest to the reference first.
class Postures {
 public:
  Postures(const Chain& chain, const JointVector& reference, double separation)
      : chain_(chain), reference_(reference), separation_(separation) {
    found_.reserve(kMaxPostures + 1);
  }

  // Keeps the nearer one of two that are alike.
  void add(const IkResult& result) {
    const auto nearer = [this](const IkResult& a, const IkResult& b) {
      return (a.q - reference_).squaredNorm() < (b.q - reference_).squaredNorm();
    };
    const auto alike = [this, &result](const IkResult& other) { return same(result.q, other.q); };
    const auto twin = std::find_if(found_.begin(), found_.end(), alike);
    if (twin != found_.end()) {
      if (!nearer(result, *twin)) return;
      found_.erase(std::remove_if(twin, found_.end(), alike), found_.end());
    }
    found_.insert(std::upper_bound(found_.begin(), found_.end(), result, nearer), result);
    if (found_.size() > kMaxPostures) found_.pop_back();
  }

  std::vector<IkResult> take(int count) && {
    found_.resize(std::min(found_.size(), static_cast<std::size_t>(count)));
    return std::move(found_);
  }

 private:
  bool same(const JointVector& a, const JointVector& b) const {
    for (int i = 0; i < chain_.joints(); ++i) {
      double away = std::abs(a[i] - b[i]);
      if (wraps(chain_, i)) away = std::abs(std::remainder(away, kTurn));
      if (away > separation_) return false;
    }
    return true;
  }

  const Chain& chain_;
  const JointVector& reference_;
  double separation_;
  std::vector<IkResult> found_;
};

}  // namespace

std::vector<IkResult> solve_ik_all(const Chain& chain, const IkTarget& target,
                                   const Eigen::Ref<const Eigen::VectorXd>& q0,
                                   const IkOptions& options, int count, double separation) {
  check_argument(count >= 0, "count: expected none or more");
  check_options(chain, options, target.rotation.has_value());
  const JointVector start = project(chain, q0);
  const JointVector reference = options.reference.value_or(start);
  Postures postures(chain, reference, separation);
  visit_target(target, options.axes, [&](auto dimension, const auto& seen) {
    constexpr int M = decltype(dimension)::value;
    PoseSearch<M, std::decay_t<decltype(seen)>> search(chain, seen, options, start, 0);
    while (search.attempt()) {
      check_interrupt();
      if (!search.found()) continue;
      search.take_turns_near(reference);
      search.approach(towards(reference), 1.0);
      postures.add(search.result(IkStatus::kConverged));
    }
  });
  return std::move(postures).take(count);
}

}  // namespace leadthrough
