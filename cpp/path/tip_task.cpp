#include "path/tip_task.hpp"

#include "rotation/so3.hpp"

namespace leadthrough::path {

namespace {

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

}  // namespace

TipTask::TipTask(const Chain& chain, const TipPath& path, double sample)
    : chain_(chain), axes_(path.axes), target_(target_at(path, sample)) {}

bool TipTask::settle(const DescentBounds& bounds, const IkTolerance& tolerance, JointArray& q,
                     int max_iterations) const {
  return leadthrough::settle(chain_, target_, axes_, bounds, tolerance, max_iterations, q);
}

// The rows of the Jacobian, made orthonormal, are taken out of the joints' axes, the axis that
// keeps most first.
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
    // What the axes keep of themselves: 1 less the squares already taken.
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
