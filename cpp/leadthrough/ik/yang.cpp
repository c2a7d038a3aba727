#include "leadthrough/ik/yang.hpp"

#include <algorithm>
#include <functional>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/base/orthogonal.hpp"
#include "leadthrough/base/parallel.hpp"
#include "leadthrough/ik/joint_ranges.hpp"

namespace leadthrough {

namespace {

// Transposed: a column for each direction of the task.
using TaskDirections = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJoints, 6>;
using SquareTask = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;
using SmallTwist = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;

// Directions below this fraction of the largest singular value count as lost: the secondary task's
// motion along them does not move the tool.
constexpr double kLost = 1e-9;

// The whole of what is left to the target, base frame.
struct Offset {
  Vector6 twist = Vector6::Zero();
  double position_error = 0.0, orientation_error = 0.0;
};

Offset offset_to(const IkTarget& target, const Transform& pose) {
  Offset offset;
  offset.twist.head<3>() = target.position - pose.position;
  if (target.rotation)
    offset.twist.tail<3>() = rotation_vector(*target.rotation * pose.rotation.transpose());
  offset.position_error = offset.twist.head<3>().norm();
  offset.orientation_error = offset.twist.tail<3>().norm();
  return offset;
}

// Moves q for dt at the velocity, inside the limits.
void advance(const Chain& chain, const JointVector& velocity, double dt, JointVector& q) {
  q = project(chain, JointVector(q + dt * velocity));
}

}  // namespace

YangStep yang_step(const Chain& chain, const double* q, const Vector6& twist, bool positions_only,
                   const YangOptions& options) {
  const int n = chain.joints(), rows = positions_only ? 3 : 6;
  Kinematics kinematics;
  forward_kinematics(chain, q, kinematics);
  Vector6 weight = Vector6::Ones();
  weight.tail<3>().setConstant(options.rotation_weight);
  TaskDirections directions(n, rows);
  for (int i = 0; i < n; ++i)
    directions.row(i) =
        kinematics.jacobian[static_cast<std::size_t>(i)].cwiseProduct(weight).head(rows);
  const SmallTwist wanted = twist.cwiseProduct(weight).head(rows);

  // J = U S V^T, of which `directions` becomes V S.
  SquareTask left = SquareTask::Identity(rows, rows);
  orthogonalize_columns(directions, left);
  SmallTwist sigma = directions.colwise().norm();
  const int rank = std::min(rows, n);
  std::partial_sort(sigma.begin(), sigma.begin() + rank, sigma.end(), std::greater<>());
  const double largest = sigma[0], smallest = sigma[rank - 1];
  YangStep step;
  step.condition = smallest > 0.0 ? largest / smallest : kInfinity;  // equation 4
  const double share = options.condition_threshold / step.condition;
  step.damping = options.damping * std::sqrt(std::max(1.0 - share * share, 0.0));

  JointVector q_now = Eigen::Map<const Eigen::VectorXd>(q, n);
  JointVector pull = options.nullspace_gain * (middle(chain) - q_now);
  for (int i = 0; i < n; ++i)
    if (!std::isfinite(chain.lower[i] + chain.upper[i])) pull[i] = 0.0;
  const double regular = step.damping * step.damping + options.alpha;
  step.velocity = JointVector::Zero(n);
  JointVector secondary = pull;
  for (Eigen::Index k = 0; k < rows; ++k) {
    const auto direction = directions.col(k);
    const double square = direction.squaredNorm();
    const bool lost = square <= kLost * kLost * largest * largest;
    if (!lost || regular > 0.0)  // equation 5, by the singular values
      step.velocity += direction * (left.col(k).dot(wanted) / (square + regular));
    if (!lost) secondary -= direction * (direction.dot(pull) / square);  // equation 6
  }
  step.velocity += secondary;  // equation 7
  return step;
}

IkResult solve_yang(const Chain& chain, const IkTarget& target, const VectorRef& q0,
                    const IkTolerance& tolerance, int max_iterations, const YangOptions& options) {
  const double farthest = reach(chain);
  IkResult result;
  result.q = project(chain, q0);
  for (;; ++result.iterations) {
    check_interrupt();
    Offset offset = offset_to(target, forward_kinematics(chain, result.q.data()));
    result.position_error = offset.position_error;
    result.orientation_error = offset.orientation_error;
    const bool met = offset.position_error <= tolerance.position &&
                     offset.orientation_error <= tolerance.orientation;
    if (met) result.status = IkStatus::kConverged;
    if (met || result.iterations >= max_iterations) break;
    // A step longer than the arm is meaningless.
    if (offset.position_error > farthest)
      offset.twist.head<3>() *= farthest / offset.position_error;
    const YangStep step =
        yang_step(chain, result.q.data(), offset.twist, !target.rotation, options);
    advance(chain, step.velocity, 1.0, result.q);
  }
  const double distance = (target.position - chain.fixed[0].position).norm();
  if (result.status != IkStatus::kConverged && distance > farthest + tolerance.position)
    result.status = IkStatus::kUnreachable;
  return result;
}

std::vector<IkResult> solve_yang_batch(const Chain& chain, const Rows3Ref& positions,
                                       const Rows4Ref& orientations, const RowsRef& starts,
                                       const IkTolerance& tolerance, int max_iterations,
                                       const YangOptions& options, int threads) {
  check_argument(orientations.rows() == positions.rows() || orientations.rows() == 0,
                 "orientations: expected a row for each position, or none");
  check_argument(starts.rows() == positions.rows() && starts.cols() == chain.joints(),
                 "starts: expected a row for each position and one value a joint");
  std::vector<IkResult> results(static_cast<std::size_t>(positions.rows()));
  for_each_index(results.size(), threads, [&](std::size_t i) {
    const auto row = static_cast<Eigen::Index>(i);
    const JointVector q0 = starts.row(row);
    results[i] = solve_yang(chain, target_in_row(positions, orientations, row), q0, tolerance,
                            max_iterations, options);
  });
  return results;
}

YangPath yang_path(const Chain& chain, const Rows3Ref& positions, const Rows4Ref& orientations,
                   const VectorRef& start, const VectorRef& steps, const YangOptions& options) {
  check_argument(orientations.rows() == positions.rows() || orientations.rows() == 0,
                 "orientations: expected a row for each position, or none");
  check_argument(steps.size() == positions.rows(), "steps: expected one for each position");
  const Eigen::Index samples = positions.rows();
  YangPath path{Rows(samples, chain.joints()), Eigen::VectorXd(samples), Eigen::VectorXd(samples),
                Eigen::VectorXd(samples), Eigen::VectorXd(samples)};
  JointVector q = project(chain, start);
  for (Eigen::Index k = 0; k < samples; ++k) {
    check_interrupt();
    const IkTarget target = target_in_row(positions, orientations, k);
    const Offset before = offset_to(target, forward_kinematics(chain, q.data()));
    const YangStep step =
        yang_step(chain, q.data(), before.twist / steps[k], !target.rotation, options);
    advance(chain, step.velocity, steps[k], q);
    const Offset after = offset_to(target, forward_kinematics(chain, q.data()));
    path.q.row(k) = q;
    path.condition[k] = step.condition;
    path.damping[k] = step.damping;
    path.position_errors[k] = after.position_error;
    path.orientation_errors[k] = after.orientation_error;
  }
  return path;
}

}  // namespace leadthrough
