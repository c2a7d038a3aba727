#include "leadthrough/path/tip_task.hpp"

#include <Eigen/Cholesky>

#include "leadthrough/rotation/so3.hpp"

namespace leadthrough::path {

namespace {

constexpr double kEdge = 0.98;      // of a tube, to which the tip is brought from outside
constexpr double kMinWidth = 1e-3;  // m or rad: narrower axes stay on the path

// The path's pose at a sample: straight, and about one axis, between two rows.
IkTarget target_at(const TipPath& path, double sample) {
  const Eigen::Index last = path.positions.rows() - 1;
  const Eigen::Index row =
      std::min(static_cast<Eigen::Index>(sample), std::max<Eigen::Index>(last - 1, 0));
  const double share = sample - static_cast<double>(row);
  IkTarget target = target_in_row(path.positions, path.orientations, row);
  if (share <= 0.0 || last == 0) return target;
  const IkTarget next = target_in_row(path.positions, path.orientations, row + 1);
  if (share >= 1.0) return next;
  target.position += share * (next.position - target.position);
  if (target.rotation) {
    const Eigen::Vector3d turn = rotation_vector(*next.rotation * target.rotation->transpose());
    const double angle = turn.norm();
    if (angle > 0.0)
      target.rotation =
          Eigen::AngleAxisd(share * angle, turn / angle).toRotationMatrix() * *target.rotation;
  }
  return target;
}

// The tube at a sample, for the task's axes.
std::optional<Tube> tube_at(const TipPath& path, double sample) {
  if (path.tube.rows() == 0) return std::nullopt;
  const Eigen::Index last = path.positions.rows() - 1;
  const Eigen::Index row = std::min(static_cast<Eigen::Index>(sample), last);
  const double share = sample - static_cast<double>(row);
  Eigen::Matrix<double, 6, 6> spread = path.tube.middleRows<6>(6 * row);
  if (share > 0.0 && row < last)
    spread += share * (path.tube.middleRows<6>(6 * (row + 1)) - spread);
  Tube tube;
  int asked = 0, count = 0;
  for (int k = 0; k < (path.orientations.rows() > 0 ? 6 : 3); ++k) {
    if (path.axes->free[static_cast<std::size_t>(k)]) continue;
    tube.scale[asked] = path.axes->weight[k] * (k < 3 ? 1.0 : kOrientationWeight);
    if (spread(k, k) > kMinWidth * kMinWidth) {
      tube.rows[static_cast<std::size_t>(count)] = asked;
      tube.axes[static_cast<std::size_t>(count++)] = k;
    }
    ++asked;
  }
  if (count == 0) return std::nullopt;
  const auto axes = Eigen::Map<const Eigen::VectorXi>(tube.axes.data(), count);
  const Eigen::LLT<Eigen::MatrixXd> cholesky(Eigen::MatrixXd(spread(axes, axes)));
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  tube.factor = Eigen::MatrixXd(cholesky.matrixL());
  tube.inverse =
      tube.factor.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(count, count));
  return tube;
}

}  // namespace

TubePlace Tube::place(const Vector6& error) const {
  TubePlace room(dimension());
  for (int k = 0; k < dimension(); ++k) {
    const int row = rows[static_cast<std::size_t>(k)];
    room[k] = error[row] / scale[row];
  }
  return inverse * room;
}

TipTask::TipTask(const Chain& chain, const TipPath& path, double sample)
    : chain_(chain),
      axes_(path.axes),
      target_(target_at(path, sample)),
      tube_(tube_at(path, sample)) {}

TubePlace TipTask::place(const JointArray& q) const {
  if (!tube_) return {};
  TipError error;
  evaluate(q, error);
  return tube_->place(error.error);
}

// The target with the tip at a position of the tube. Along free axes it is q's own.
IkTarget TipTask::moved(const TubePlace& place, const JointArray& q) const {
  const Eigen::Matrix3d frame = target_.rotation.value_or(Eigen::Matrix3d::Identity());
  Kinematics kinematics;
  forward_kinematics(chain_, q.data(), kinematics);
  const Eigen::Vector3d away =
      frame.transpose() * (target_.position - kinematics.T_base_tip.position);
  Vector6 error = Vector6::Zero();
  for (int k = 0; k < 3; ++k)
    if (axes_->free[static_cast<std::size_t>(k)]) error[k] = away[k];
  const TubePlace room = tube_->factor * place;
  for (int k = 0; k < tube_->dimension(); ++k)
    error[tube_->axes[static_cast<std::size_t>(k)]] = room[k];
  IkTarget target = target_;
  target.position -= frame * error.head<3>();
  const double angle = error.tail<3>().norm();
  if (target.rotation && angle > 0.0)
    target.rotation = frame * Eigen::AngleAxisd(-angle, error.tail<3>() / angle).toRotationMatrix();
  return target;
}

bool TipTask::settle_at(const TubePlace& place, const JointBox& bounds,
                        const IkTolerance& tolerance, JointArray& q, int max_iterations) const {
  if (!tube_)
    return leadthrough::settle(chain_, target_, axes_, bounds, tolerance, max_iterations, q);
  const TubePlace wanted = place.size() > 0 ? place : TubePlace::Zero(tube_->dimension());
  // A free axis rotates with the target: whether the tip is inside the tube must be tested.
  return leadthrough::settle(chain_, moved(wanted, q), axes_, bounds, tolerance, max_iterations,
                             q) &&
         this->place(q).norm() <= 1.0;
}

bool TipTask::settle(const JointBox& bounds, const IkTolerance& tolerance, JointArray& q,
                     int max_iterations) const {
  TubePlace at = place(q);
  const double length = at.norm();
  if (length > kEdge) at *= kEdge / length;
  return settle_at(at, bounds, tolerance, q, max_iterations);
}

// The rows of the Jacobian, orthonormalised, are projected out of the joints' axes, the axis with
// the largest remainder first.
FreeDirections TipTask::free_directions(const JointArray& q) const {
  constexpr double kDependent = 1e-4;  // m a rad: at a singularity a row adds nothing
  TipError error;
  evaluate(q, error);
  const int n = chain_.joints();
  Eigen::Matrix<double, kMaxJoints, kMaxJoints> taken;  // a column each, orthonormal
  int count = 0;
  const auto take = [&](JointVector row, double least) {
    for (int pass = 0; pass < 2; ++pass)
      for (int k = 0; k < count; ++k) row -= taken.col(k).head(n).dot(row) * taken.col(k).head(n);
    const double length = row.norm();
    if (length <= least) return false;
    taken.col(count++).head(n) = row / length;
    return true;
  };
  for (int r = 0; r < error.rows; ++r) {
    JointVector row(n);
    for (int i = 0; i < n; ++i) row[i] = error.columns[static_cast<std::size_t>(i)][r];
    take(row, kDependent);
  }
  FreeDirections found;
  while (count < n) {
    // Remainder of each axis: 1 less the squares already taken.
    Eigen::Index widest = 0;
    const JointVector kept =
        JointVector::Ones(n) - taken.topLeftCorner(n, count).rowwise().squaredNorm();
    kept.maxCoeff(&widest);
    if (!take(JointVector::Unit(n, widest), 1e-6)) break;
    const auto direction = taken.col(count - 1).head(n);
    JointArray& next = found.directions[static_cast<std::size_t>(found.count++)];
    std::copy(direction.data(), direction.data() + n, next.begin());
    const double largest = direction.cwiseAbs().maxCoeff();
    for (double& element : next) element /= largest;
  }
  return found;
}

void TipTask::evaluate(const JointArray& q, TipError& error) const {
  leadthrough::evaluate(chain_, target_, axes_, q, error);
}

}  // namespace leadthrough::path
