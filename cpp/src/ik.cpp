#include "leadthrough/ik.hpp"

#include <limits>

#include "parallel.hpp"
#include "pose_descent.hpp"

namespace leadthrough {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// SplitMix64, Steele, Lea and Flood 2014: the standard library's distributions differ by vendor.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t stream) : state_(seed) {
    state_ = next() ^ (stream * 0xd1342543de82ef95U);
  }

  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

 private:
  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
};

// A joint that can turn once around wraps instead of stopping at its limits.
bool wraps(const Chain& chain, int i) {
  return chain.turns[static_cast<std::size_t>(i)] && chain.upper[i] - chain.lower[i] >= 2.0 * kPi;
}

// The whole turns that bring an angle nearest to another one without leaving the limits.
double wrapped(double angle, double near, double lower, double upper) {
  constexpr double kTurn = 2.0 * kPi;
  angle += kTurn * std::round((near - angle) / kTurn);
  if (angle < lower) angle += kTurn * std::ceil((lower - angle) / kTurn);
  if (angle > upper) angle -= kTurn * std::ceil((angle - upper) / kTurn);
  return std::clamp(angle, lower, upper);
}

JointArray random_configuration(const Chain& chain, RandomStream& random) {
  JointArray q{};
  for (int i = 0; i < chain.joints(); ++i) {
    // A joint without bounds is sampled over one turn, or a metre to both sides.
    const double reach = chain.turns[static_cast<std::size_t>(i)] ? kPi : 1.0;
    const bool from = std::isfinite(chain.lower[i]), to = std::isfinite(chain.upper[i]);
    const double lower = from ? chain.lower[i] : to ? chain.upper[i] - 2.0 * reach : -reach;
    const double upper = to ? chain.upper[i] : from ? chain.lower[i] + 2.0 * reach : reach;
    q[static_cast<std::size_t>(i)] = lower + random.uniform() * (upper - lower);
  }
  return q;
}

template <int M>
class Solver {
 public:
  Solver(const Chain& chain, const IkTarget& target, const IkOptions& options)
      : chain_(chain), target_(target), options_(options), n_(chain.joints()) {
    for (int i = 0; i < n_; ++i) {
      const auto k = static_cast<std::size_t>(i);
      wraps_[k] = wraps(chain, i);
      limits_.lower[k] = chain.lower[i];
      limits_.upper[k] = chain.upper[i];
    }
  }

  IkResult solve(const Eigen::Ref<const Eigen::VectorXd>& seed, std::uint64_t stream) {
    const JointVector start = project(chain_, seed);
    std::copy(start.data(), start.data() + n_, q_.begin());
    RandomStream random(options_.random_seed, stream);
    const double distance = (target_.position - chain_.fixed[0].position).norm();
    const bool beyond = distance > reach(chain_) + options_.tolerance.position;
    const int restarts = beyond ? 0 : options_.max_restarts;
    IkStatus status = IkStatus::kStalled;
    JointArray best = q_;
    double least = kInfinity;
    for (int attempt = 0; attempt <= restarts; ++attempt) {
      if (attempt > 0) q_ = random_configuration(chain_, random);
      status = run_attempt();
      if (status != IkStatus::kStalled) break;
      if (task_.squared() < least) {
        least = task_.squared();
        best = q_;
      }
    }
    if (status != IkStatus::kConverged) {
      if (task_.squared() > least) q_ = best;
      status = come_close(beyond ? IkStatus::kUnreachable : status);
    }
    const bool centred = status == IkStatus::kConverged && n_ > M && options_.midrange > 0.0;
    const JointVector goal = centred ? middle(chain_) : start;
    take_turns_near(goal);
    if (centred) approach_middle();
    return result(status);
  }

 private:
  // Steps until the target is met or two net steps gained less than 30 %.
  IkStatus run_attempt() {
    constexpr double kGoodStep = 0.7;
    constexpr int kPatience = 2;
    evaluate(chain_, target_, q_.data(), task_);
    const JointArray zero{};
    JointArray lower{}, upper{};
    int idle = 0;
    double attempt_least = task_.squared();
    while (!task_.within(options_.tolerance)) {
      if (iterations_ >= options_.max_iterations) return IkStatus::kBudget;
      const double squared = task_.squared();
      for (std::size_t i = 0; i < count(); ++i) {
        lower[i] = wraps_[i] ? -kInfinity : limits_.lower[i] - q_[i];
        upper[i] = wraps_[i] ? kInfinity : limits_.upper[i] - q_[i];
      }
      move(boxed_step(task_, n_, kErrorDamping * squared, zero, lower, upper));
      evaluate(chain_, target_, q_.data(), task_);
      ++iterations_;
      // Measured against the least error so far: a cycle makes no progress.
      idle = task_.squared() > kGoodStep * attempt_least ? idle + 1 : std::max(idle - 1, 0);
      attempt_least = std::min(attempt_least, task_.squared());
      if (idle >= kPatience && !task_.within(options_.tolerance)) return IkStatus::kStalled;
    }
    return IkStatus::kConverged;
  }

  void move(const JointArray& step) {
    for (std::size_t i = 0; i < count(); ++i) {
      q_[i] += step[i];
      q_[i] = wraps_[i] ? wrapped(q_[i], q_[i], limits_.lower[i], limits_.upper[i])
                        : std::clamp(q_[i], limits_.lower[i], limits_.upper[i]);
    }
  }

  // From the best attempt to the nearest configuration that a descent finds.
  IkStatus come_close(IkStatus reason) {
    constexpr int kLastSteps = 100;
    PoseDescent<M> descent(chain_, target_, limits_, q_);
    const DescentEnd end = descent.run(options_.tolerance, kLastSteps);
    q_ = descent.q();
    iterations_ += end.iterations;
    evaluate(chain_, target_, q_.data(), task_);
    return end.status == IkStatus::kConverged ? IkStatus::kConverged : reason;
  }

  // Of the turns of a joint that wraps, the one nearest to `goal`.
  void take_turns_near(const JointVector& goal) {
    for (int i = 0; i < n_; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (wraps_[k]) q_[k] = wrapped(q_[k], goal[i], limits_.lower[k], limits_.upper[k]);
    }
  }

  double distance_to_middle(const JointArray& q) const {
    double sum = 0.0;
    for (const double away : pull_to_middle(chain_, q, 1.0)) sum += away * away;
    return sum;
  }

  // Self-motion in the exact null space, I - J^+ J of the undamped J, each step put back onto the
  // target and kept if it brought the joints nearer to the middle of their ranges.
  void approach_middle() {
    constexpr int kSteps = 20;
    constexpr int kBackSteps = 5;
    constexpr double kLeastGain = 1e-4;        // of the distance
    constexpr double kWellConditioned = 1e-9;  // pivots of J J^T: next to a singularity stay
    double distance = distance_to_middle(q_);
    double share = std::min(options_.midrange, 1.0);
    for (int k = 0; k < kSteps && iterations_ < options_.max_iterations; ++k) {
      DampedNormal<M> normal(task_, n_, 0.0, [](int) { return true; });
      if (!normal.factorize(kWellConditioned)) return;
      const JointArray pull = pull_to_middle(chain_, q_, share);
      JointArray trial = q_;
      TaskVector<M> leak = TaskVector<M>::Zero();
      for (std::size_t i = 0; i < count(); ++i) leak += pull[i] * task_.columns[i];
      const TaskVector<M> dual = normal.solve(leak);
      for (std::size_t i = 0; i < count(); ++i)
        trial[i] = std::clamp(q_[i] + pull[i] - task_.columns[i].dot(dual), limits_.lower[i],
                              limits_.upper[i]);
      PoseDescent<M> descent(chain_, target_, limits_, trial);
      const DescentEnd end = descent.run(options_.tolerance, kBackSteps);
      trial = descent.q();
      iterations_ += 1 + end.iterations;
      const double nearer = distance_to_middle(trial);
      if (end.status != IkStatus::kConverged || nearer >= distance) {
        share *= 0.5;
        continue;
      }
      q_ = trial;
      evaluate(chain_, target_, q_.data(), task_);
      if (nearer > (1.0 - kLeastGain) * distance) return;
      distance = nearer;
    }
  }

  IkResult result(IkStatus status) {
    IkResult answer;
    answer.q = Eigen::Map<const Eigen::VectorXd>(q_.data(), n_);
    answer.status = status;
    answer.position_error = task_.position_error;
    answer.orientation_error = task_.orientation_error;
    answer.iterations = iterations_;
    return answer;
  }

  std::size_t count() const { return static_cast<std::size_t>(n_); }

  const Chain& chain_;
  const IkTarget& target_;
  const IkOptions& options_;
  int n_;
  std::array<bool, kMaxJoints> wraps_{};
  DescentBounds limits_{};
  JointArray q_{};
  Task<M> task_;
  int iterations_ = 0;
};

}  // namespace

JointVector project(const Chain& chain, const Eigen::Ref<const Eigen::VectorXd>& q) {
  JointVector inside(chain.joints());
  for (int i = 0; i < chain.joints(); ++i)
    inside[i] = wraps(chain, i) ? wrapped(q[i], q[i], chain.lower[i], chain.upper[i])
                                : std::clamp(q[i], chain.lower[i], chain.upper[i]);
  return inside;
}

JointVector middle(const Chain& chain) {
  JointVector centre(chain.joints());
  for (int i = 0; i < chain.joints(); ++i) {
    const double sum = 0.5 * chain.lower[i] + 0.5 * chain.upper[i];
    centre[i] = std::isfinite(sum) ? sum : std::clamp(0.0, chain.lower[i], chain.upper[i]);
  }
  return centre;
}

IkResult solve_ik(const Chain& chain, const IkTarget& target,
                  const Eigen::Ref<const Eigen::VectorXd>& seed, const IkOptions& options,
                  std::uint64_t stream) {
  if (target.rotation) return Solver<6>(chain, target, options).solve(seed, stream);
  return Solver<3>(chain, target, options).solve(seed, stream);
}

std::vector<IkResult> solve_ik_batch(const Chain& chain, const Eigen::Ref<const Rows3>& positions,
                                     const Eigen::Ref<const Rows4>& orientations,
                                     const Eigen::Ref<const Rows>& seeds, const IkOptions& options,
                                     int threads) {
  const auto count = static_cast<std::size_t>(positions.rows());
  std::vector<IkResult> results(count);
  for_each_index(count, threads, [&](std::size_t i) {
    const auto row = static_cast<Eigen::Index>(i);
    IkTarget target{positions.row(row), std::nullopt};
    if (orientations.rows() > 0)
      target.rotation = so3::to_matrix(Eigen::Vector4d(orientations.row(row)));
    const JointVector seed = seeds.row(row);
    results[i] = solve_ik(chain, target, seed, options, i);
  });
  return results;
}

}  // namespace leadthrough
