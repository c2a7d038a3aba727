#include "leadthrough/ik/task_priority.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/orthogonal.hpp"
#include "leadthrough/ik/polytope.hpp"

namespace leadthrough {

namespace {

// Singular values below this fraction of the whole Jacobian's norm are rounding: no range.
constexpr double kRankTolerance = 1e-12;
// The same for single rows that become bounds: a lower level moves them by no more.
constexpr double kLeftover = 1e-11;
// Singular value below which damping is always on, m or rad (weighted) per rad.
constexpr double kNearSingular = 0.02;
// Cost of motion that a level does not constrain, relative to a residual of 1 m/s at 1 rad/s.
constexpr double kIdleWeight = 1e-8;

// Chiaverini 1997, eq. (22), squared once more so that the damping is smooth at its onset: it grows
// with the demand along this direction, so that joint rates near the singularity are bounded by
// `quickness`.
double damping(double sigma, double asked, double quickness) {
  const double onset = kNearSingular * kNearSingular + asked / quickness;
  const double fade = 1.0 - std::min(sigma * sigma / onset, 1.0);
  return onset * fade * fade;
}

// jacobian = sum_i sigma_i u_i v_i^T; pull_i = sigma_i u_i^T error.
struct Range {
  Eigen::Index rank = 0;
  TaskMatrix right;  // v_i, a row each
  JointVector sigma, pull;
};

Range numerical_range(const TaskMatrix& jacobian, const JointVector& error, double scale) {
  const bool wide = jacobian.rows() <= jacobian.cols();
  TaskMatrix rows = jacobian;
  TaskMatrix right = TaskMatrix::Identity(jacobian.cols(), jacobian.cols());
  JointVector turned_error = error;
  const double negligible = kRankTolerance * scale;
  if (!wide) rows = jacobian.transpose();
  const auto rotate = [&](Eigen::Index p, Eigen::Index q, double cosine, double sine) {
    if (wide)
      rotate_columns(turned_error.transpose(), p, q, cosine, sine);
    else
      rotate_columns(right.transpose(), p, q, cosine, sine);
  };
  orthogonalize_columns(rows.transpose(), 0.1 * negligible, rotate);
  Range range{0, TaskMatrix(rows.rows(), jacobian.cols()), JointVector(rows.rows()),
              JointVector(rows.rows())};
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const double sigma = rows.row(i).norm();
    if (!(sigma > negligible)) continue;
    const Eigen::Index k = range.rank++;
    range.sigma[k] = sigma;
    if (wide) {
      range.right.row(k) = rows.row(i) / sigma;
      range.pull[k] = sigma * turned_error[i];
    } else {
      range.right.row(k) = right.row(i);
      range.pull[k] = rows.row(i).dot(error);
    }
  }
  return range;
}

// Rotates the columns of `basis` so that the first ones span those directions (rows of `right`, in
// coordinates of the basis) and the others their complement: Householder reflections.
template <typename Basis>
void put_first(const TaskMatrix& right, Eigen::Index rank, Basis& basis) {
  TaskMatrix rest = right;
  for (Eigen::Index k = 0; k < rank; ++k) {
    JointVector mirror = JointVector::Zero(right.cols());
    mirror.tail(right.cols() - k) = rest.row(k).tail(right.cols() - k).transpose();
    mirror[k] += std::copysign(mirror.norm(), mirror[k]);
    const double scale = 2.0 / mirror.squaredNorm();
    for (Eigen::Index row = k; row < rank; ++row)
      rest.row(row) -= scale * rest.row(row).dot(mirror) * mirror.transpose();
    for (Eigen::Index row = 0; row < basis.rows(); ++row)
      basis.row(row) -= scale * basis.row(row).dot(mirror) * mirror.transpose();
  }
}

// At most the joints' bounds and one row a unilateral level.
constexpr int kMaxUnilateral = 48;

// One pass down the levels of a stack.
class PriorityPass {
 public:
  // Starts from the motion inside the box that is nearest to rest.
  PriorityPass(const MotionBox& box, double quickness);

  // Comes as near to jacobian * motion = wanted as the levels before and the bounds allow, and
  // constrains later levels to preserve it. True if a bound is active.
  bool equal(const TaskMatrix& jacobian, const JointVector& wanted);
  // The same for jacobian * motion >= wanted, one row.
  bool at_least(const TaskMatrix& jacobian, double wanted);

  const JointVector& motion() const { return motion_; }

 private:
  using Basis = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxJoints,
                              kMaxJoints>;
  using Polytope = leadthrough::Polytope<kMaxJoints + kMaxUnilateral, kMaxJoints>;
  // A change of the motion along `basis`: the least sum of weight * (coordinate - pull / weight)^2.
  struct Step {
    Basis basis;
    JointVector pull, weight;
    Eigen::Index rank = 0;  // number of leading coordinates in the level's range
  };

  Step plan(const TaskMatrix& jacobian, const JointVector& wanted) const;
  bool move(const Step& step);
  static JointVector nearest(const Step& step, double damping, Polytope::Rows rows,
                             const Polytope::Sides& lower, const Polytope::Sides& upper);

  MotionBox box_;
  double quickness_;
  JointVector motion_;
  Basis free_;  // orthonormal columns
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMaxUnilateral, kMaxJoints>
      rows_;  // of the unilateral levels so far
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxUnilateral, 1> bounds_;
};

PriorityPass::PriorityPass(const MotionBox& box, double quickness)
    : box_(box),
      quickness_(quickness),
      motion_(box.lower.size()),
      rows_(0, box.lower.size()),
      bounds_(0) {
  const Eigen::Index n = motion_.size();
  for (Eigen::Index i = 0; i < n; ++i) motion_[i] = std::clamp(0.0, box.lower[i], box.upper[i]);
  free_ = Basis::Identity(n, n);
}

bool PriorityPass::equal(const TaskMatrix& jacobian, const JointVector& wanted) {
  const Step step = plan(jacobian, wanted);
  const bool bounded = move(step);
  free_ = step.basis.rightCols(step.basis.cols() - step.rank).eval();
  return bounded;
}

bool PriorityPass::at_least(const TaskMatrix& jacobian, double wanted) {
  bool bounded = false;
  const double now = jacobian.row(0).dot(motion_);
  if (now < wanted) bounded = move(plan(jacobian, JointVector::Constant(1, wanted)));
  const Eigen::Index count = rows_.rows();
  rows_.conservativeResize(count + 1, Eigen::NoChange);
  bounds_.conservativeResize(count + 1);
  rows_.row(count) = jacobian.row(0);
  bounds_[count] = std::min(wanted, jacobian.row(0).dot(motion_));
  return bounded;
}

PriorityPass::Step PriorityPass::plan(const TaskMatrix& jacobian, const JointVector& wanted) const {
  const Eigen::Index free = free_.cols();
  const JointVector error = wanted - jacobian.lazyProduct(motion_);
  const TaskMatrix projected = jacobian.lazyProduct(free_);
  const Range range = numerical_range(projected, error, jacobian.norm());
  Step step{free_, JointVector::Zero(free), JointVector::Constant(free, kIdleWeight), range.rank};
  put_first(range.right, range.rank, step.basis);
  for (Eigen::Index k = 0; k < range.rank; ++k) {
    step.basis.col(k) = free_.lazyProduct(range.right.row(k).transpose());
    const double sigma = range.sigma[k];
    step.weight[k] = sigma * sigma + damping(sigma, std::abs(range.pull[k]) / sigma, quickness_);
    step.pull[k] = range.pull[k];
  }
  return step;
}

bool PriorityPass::move(const Step& step) {
  const Eigen::Index n = motion_.size(), count = n + rows_.rows(), free = step.basis.cols();
  if (free == 0) return false;
  Polytope::Rows rows(count, free);
  Polytope::Sides lower(count), upper(count);
  rows.topRows(n) = step.basis;
  for (Eigen::Index i = 0; i < n; ++i)
    if (rows.row(i).norm() <= kLeftover) rows.row(i).setZero();
  rows.bottomRows(count - n) = rows_.lazyProduct(step.basis);
  // The remainder of a unilateral level's row may be rounding alone.
  for (Eigen::Index i = n; i < count; ++i)
    if (rows.row(i).norm() <= kLeftover * rows_.row(i - n).norm()) rows.row(i).setZero();
  lower.head(n) = (box_.lower - motion_).cwiseMin(0.0);
  upper.head(n) = (box_.upper - motion_).cwiseMax(0.0);
  lower.tail(count - n) = (bounds_ - rows_.lazyProduct(motion_)).cwiseMin(0.0);
  upper.tail(count - n).setConstant(kInfinity);

  const JointVector goal = step.pull.cwiseQuotient(step.weight);
  const bool bounded = !Polytope(rows, lower, upper).contains(goal);
  JointVector reached = goal;
  if (bounded) {
    reached = nearest(step, 0.0, rows, lower, upper);
    const JointVector residuals = (goal - reached).cwiseProduct(step.weight.cwiseSqrt());
    const double residual = residuals.head(step.rank).norm();
    // An infeasible level would drive joints to their bounds for a negligible gain, and back and
    // forth when their lever changes sign. Feasible levels are met exactly.
    const double strain = residual / (1.0 + residual) / quickness_;
    if (strain > 0.0) reached = nearest(step, strain, rows, lower, upper);
  }
  motion_ += step.basis.lazyProduct(reached);
  motion_ = motion_.cwiseMax(box_.lower).cwiseMin(box_.upper);  // rounding
  return bounded;
}

JointVector PriorityPass::nearest(const Step& step, double damping, Polytope::Rows rows,
                                  const Polytope::Sides& lower, const Polytope::Sides& upper) {
  // In coordinates where a residual costs the same in every direction.
  const JointVector root = (step.weight.array() + damping).sqrt();
  for (Eigen::Index k = 0; k < rows.cols(); ++k) rows.col(k) /= root[k];
  const JointVector goal = step.pull.cwiseQuotient(root);
  return Polytope(rows, lower, upper).nearest(goal).cwiseQuotient(root);
}

JointVector forward(std::vector<Level>& levels, const MotionBox& box, double quickness) {
  PriorityPass pass(box, quickness);
  for (Level& level : levels) {
    if (!(level.activation > 0.0)) continue;
    const double less = level.relief * (1.0 / level.activation - 1.0);
    level.bounded = level.unilateral ? pass.at_least(level.jacobian, level.wanted[0] - less)
                                     : pass.equal(level.jacobian, level.wanted);
  }
  return pass.motion();
}

// The pass that aims at the demands of the levels from `top` to `held` and preserves the effect of
// `motion` on the levels from `held` on.
JointVector correct(std::vector<Level>& levels, std::size_t top, std::size_t held,
                    const JointVector& motion, const MotionBox& box, double quickness) {
  PriorityPass pass(box, quickness);
  for (std::size_t i = top; i < levels.size(); ++i) {
    Level& level = levels[i];
    if (!(level.activation > 0.0)) continue;
    JointVector wanted = level.wanted;
    if (i >= held) {
      const JointVector done = level.jacobian.lazyProduct(motion);
      wanted = level.unilateral ? done.cwiseMin(level.wanted).eval() : done;
    }
    const bool bounded = level.unilateral ? pass.at_least(level.jacobian, wanted[0])
                                          : pass.equal(level.jacobian, wanted);
    level.bounded = level.bounded || bounded;
  }
  return pass.motion();
}

// Consecutive levels that are fully active are taken in one pass: the same as one by one.
bool begins_a_pass(const std::vector<Level>& levels, std::size_t i) {
  if (levels[i].activation < 1.0) return true;
  while (i > 0)
    if (levels[--i].activation > 0.0) return levels[i].activation < 1.0;
  return true;
}

JointVector reverse(std::vector<Level>& levels, const MotionBox& box, double quickness) {
  JointVector motion = PriorityPass(box, quickness).motion();
  std::size_t held = levels.size();
  for (std::size_t i = levels.size(); i-- > 0;) {
    const double share = levels[i].activation;
    if (!(share > 0.0) || !begins_a_pass(levels, i)) continue;
    motion += share * (correct(levels, i, held, motion, box, quickness) - motion);
    held = i;
  }
  return motion.cwiseMax(box.lower).cwiseMin(box.upper);
}

}  // namespace

JointVector resolve(std::vector<Level>& levels, const MotionBox& box, PriorityScheme scheme,
                    double quickness) {
  check_argument((box.lower.array() <= box.upper.array()).all(),
                 "box: expected lower bounds up to the upper ones");
  for (Level& level : levels) level.bounded = false;
  return scheme == PriorityScheme::kForward ? forward(levels, box, quickness)
                                            : reverse(levels, box, quickness);
}

}  // namespace leadthrough
