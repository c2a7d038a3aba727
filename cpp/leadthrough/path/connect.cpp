#include "leadthrough/path/connect.hpp"

#include <algorithm>
#include <optional>
#include <random>
#include <vector>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

using Eigen::VectorXd;

// Trees grow by edges of at most this length, rad or m.
constexpr double kRange = 1.0;
// The first trees are given up after so many steps, each later pair after twice as many: some
// searches take long by chance (Luby, Sinclair and Zuckerman 1993).
constexpr long kFirstSteps = 1000;
// Corners are cut while a round makes the path shorter by this factor, down to a part of the edges.
constexpr double kWorth = 0.98, kLeast = 0.1;
constexpr long kMaxSteps = 10000000;

struct Node {
  VectorXd q;
  std::size_t parent;  // itself for a root
};
using Tree = std::vector<Node>;
using Path = std::vector<VectorXd>;

class Planner {
 public:
  Planner(const WholeArm& arm, const ConnectOptions& options)
      : edges_(arm), options_(options), random_(options.seed) {}

  std::optional<Path> search(const VectorXd& start, const Path& goals) {
    long left = options_.steps;
    for (long budget = kFirstSteps; left > 0; budget *= 2) {
      steps_ = std::min(budget, left);
      left -= steps_;
      if (auto path = grow(start, goals)) return shortened(std::move(*path));
    }
    return std::nullopt;
  }

 private:
  double uniform() { return static_cast<double>(random_() >> 11) * 0x1.0p-53; }

  bool clear(const VectorXd& from, const VectorXd& to) {
    check_interrupt();
    return edges_.clear(from.data(), to.data());
  }

  std::optional<Path> grow(const VectorXd& start, const Path& goals) {
    Tree from_start, from_goal;
    add_root(from_start, start);
    for (const VectorXd& goal : goals) add_root(from_goal, goal);
    if (from_start.empty() || from_goal.empty()) return std::nullopt;
    Tree *growing = &from_start, *other = &from_goal;
    // First straight from one to the other.
    VectorXd target = goals.front();
    while (steps_ > 0) {
      if (extend(*growing, target)) {
        const VectorXd reached = growing->back().q;
        while (extend(*other, reached) && other->back().q != reached && steps_ > 0) {
        }
        if (other->back().q == reached) return joined(from_start, from_goal);
      }
      std::swap(growing, other);
      target = sample();
    }
    return std::nullopt;
  }

  void add_root(Tree& tree, const VectorXd& q) {
    if (clear(q, q)) tree.push_back({q, tree.size()});
  }

  VectorXd sample() {
    VectorXd q(options_.lower.size());
    for (Eigen::Index j = 0; j < q.size(); ++j)
      q[j] = options_.lower[j] + uniform() * (options_.upper[j] - options_.lower[j]);
    return q;
  }

  // Adds an edge from the nearest node towards the target.
  bool extend(Tree& tree, const VectorXd& target) {
    --steps_;
    std::size_t nearest = 0;
    double least = kInfinity;
    for (std::size_t i = 0; i < tree.size(); ++i) {
      const double distance = (tree[i].q - target).squaredNorm();
      if (distance >= least) continue;
      least = distance;
      nearest = i;
    }
    const VectorXd& from = tree[nearest].q;
    const double length = std::sqrt(least);
    const VectorXd to =
        length <= kRange ? target : VectorXd(from + kRange / length * (target - from));
    if (!clear(from, to)) return false;
    tree.push_back({to, nearest});
    return true;
  }

  // Both trees end with the same configuration.
  static Path joined(const Tree& from_start, const Tree& from_goal) {
    Path path = to_root(from_start);
    std::reverse(path.begin(), path.end());
    const Path rest = to_root(from_goal);
    path.insert(path.end(), rest.begin() + 1, rest.end());
    return path;
  }

  static Path to_root(const Tree& tree) {
    Path path;
    for (std::size_t i = tree.size() - 1;; i = tree[i].parent) {
      path.push_back(tree[i].q);
      if (tree[i].parent == i) return path;
    }
  }

  Path shortened(Path path) {
    path = without_detours(path);
    for (double before = kInfinity, now = length(path); now < kWorth * before;) {
      before = now;
      cut_corners(path);
      now = length(path);
    }
    return without_detours(path);
  }

  // From each configuration straight to the last one that can be reached so.
  Path without_detours(const Path& path) {
    Path kept{path.front()};
    for (std::size_t i = 0; i + 1 < path.size();) {
      std::size_t next = path.size() - 1;
      while (next > i + 1 && !clear(path[i], path[next])) --next;
      kept.push_back(path[next]);
      i = next;
    }
    return kept;
  }

  // A straight line past each corner, as far from it as is clear.
  void cut_corners(Path& path) {
    for (std::size_t i = 1; i + 1 < path.size(); ++i)
      for (double part = 1.0; part >= kLeast; part *= 0.5) {
        const VectorXd from = path[i] + part * (path[i - 1] - path[i]);
        const VectorXd to = path[i] + part * (path[i + 1] - path[i]);
        if (!clear(from, to)) continue;
        const auto corner = path.begin() + static_cast<std::ptrdiff_t>(i);
        if (part == 1.0) {
          path.erase(corner);
          --i;
        } else {
          *corner = to;
          path.insert(corner, from);
          ++i;
        }
        break;
      }
  }

  static double length(const Path& path) {
    double sum = 0.0;
    for (std::size_t i = 1; i < path.size(); ++i) sum += (path[i] - path[i - 1]).norm();
    return sum;
  }

  EdgeTest edges_;
  const ConnectOptions& options_;
  std::mt19937_64 random_;
  long steps_ = 0;
};

}  // namespace

Rows connect(const WholeArm& arm, const VectorXd& start, const RowsRef& goals,
             const ConnectOptions& options) {
  const Eigen::Index joints = arm.scene.chain.joints();
  check_argument(start.size() == joints && goals.cols() == joints && goals.rows() > 0 &&
                     options.lower.size() == joints && options.upper.size() == joints,
                 "start, goals, lower, upper: expected one value a joint");
  check_argument(start.allFinite() && goals.allFinite() && options.lower.allFinite() &&
                     options.upper.allFinite(),
                 "start, goals, lower, upper: finite");
  check_argument(options.steps > 0 && options.steps <= kMaxSteps, "steps: from 1 to 1e7");
  Path ends;
  for (const auto& goal : goals.rowwise()) ends.emplace_back(goal.transpose());
  const std::optional<Path> path = Planner(arm, options).search(start, ends);
  Rows rows(path ? static_cast<Eigen::Index>(path->size()) : 0, joints);
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    rows.row(i) = (*path)[static_cast<std::size_t>(i)].transpose();
  return rows;
}

}  // namespace leadthrough
