#include "leadthrough/field/policy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

using Eigen::Vector3d;

constexpr std::size_t kNeighbours = 8;    // whose speeds count at a point
constexpr double kPart = 0.1;             // cells that one move is long, at most
constexpr double kStraight = 1.0 - 1e-9;  // cosine to the goal's direction near it
constexpr double kTiny = 1e-300;          // instead of a length or speed of 0

struct Parts {
  double along, across;
};

Parts parts_of(const Vector3d& away, const Vector3d& normal) {
  const double along = away.dot(normal);
  return {along, (away - along * normal).norm()};
}

}  // namespace

MarchingPolicy::MarchingPolicy(const PolicyTables& tables)
    : dimensions_(tables.goal.size()),
      arrival_(tables.arrival),
      owner_(tables.owner),
      mean_speed_(tables.mean_speed),
      slowing_(tables.slowing),
      speeds_(tables.speeds) {
  const Eigen::Index d = dimensions_, count = speeds_.size();
  check_argument((d == 2 || d == 3) && tables.shape.size() == d && tables.spacing.size() == d,
                 "goal, shape, spacing: expected two or three dimensions");
  check_argument(tables.shape.minCoeff() >= 1.0 && tables.spacing.minCoeff() > 0.0,
                 "shape, spacing: expected positive numbers");
  check_argument(count > 0 && tables.positions.rows() == count && tables.positions.cols() == d,
                 "positions: expected a speed for each");
  origin_ = padded(tables.origin);
  goal_ = padded(tables.goal);
  positions_ = Eigen::Matrix3Xd::Zero(3, count);
  positions_.bottomRows(d) = tables.positions.transpose();
  spacing_ << tables.spacing.head(3 - d), tables.spacing;
  cell_ = spacing_.maxCoeff();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    grid_.spacing[axis] = spacing_[i];
    if (i >= 3 - d) grid_.shape[axis] = static_cast<Index>(tables.shape[i - (3 - d)]);
  }
  if (const auto& disc = tables.barrier)
    barrier_ = {padded(disc->middle), padded(disc->normal), disc->width, disc->thickness};
}

DescentStatus MarchingPolicy::velocity(const PositionIn& position, PositionOut result) const {
  check_argument(result.size() == dimensions_, "result: expected the policy's dimensions");
  Vector3d velocity;
  const DescentStatus status = velocity_at(padded(position), velocity);
  if (status == DescentStatus::kOk) result = velocity.tail(dimensions_);
  return status;
}

DescentStatus MarchingPolicy::step(double dt, PositionOut position) const {
  check_argument(dt > 0.0 && std::isfinite(dt), "dt: expected seconds > 0");
  Vector3d point = padded(position);
  DescentStatus status = DescentStatus::kOk;
  while (dt > 0.0) {
    check_interrupt();
    Vector3d velocity;
    status = velocity_at(point, velocity);
    if (status != DescentStatus::kOk) break;
    const Vector3d ahead = goal_ - point;
    const double left = ahead.norm(), speed = velocity.norm();
    if (left <= cell_ && velocity.dot(ahead) >= kStraight * left * speed) {
      point -= std::expm1(-dt * speed / std::max(left, kTiny)) * ahead;
      break;
    }
    const double part = std::min(dt, kPart * cell_ / std::max(speed, kTiny));
    point += part * velocity;
    dt -= part;
  }
  position = point.tail(dimensions_);
  return status;
}

bool MarchingPolicy::Barrier::contains(const Vector3d& point) const {
  const Parts parts = parts_of(point - middle, normal);
  return std::abs(parts.along) <= thickness && parts.across <= width;
}

// Beyond the barrier, where the motion starts, or beside it.
bool MarchingPolicy::Barrier::is_passed(const Vector3d& point) const {
  const Parts parts = parts_of(point - middle, normal);
  return parts.along > -thickness || parts.across > width;
}

Vector3d MarchingPolicy::padded(const PositionIn& position) const {
  check_argument(position.size() == dimensions_, "position: expected the policy's dimensions");
  Vector3d result = Vector3d::Zero();
  result.tail(dimensions_) = position;
  return result;
}

// More than the squares of the distances to the nearest ones, so that few others are sorted.
double MarchingPolicy::farther_than_nearest(const Vector3d& point) const {
  constexpr auto kCount = static_cast<Eigen::Index>(kNeighbours);
  const Eigen::Index count = positions_.cols();
  if (count < kCount) return std::numeric_limits<double>::infinity();
  const auto square = [&](Eigen::Index i) { return (positions_.col(i) - point).squaredNorm(); };
  Eigen::Index near = 0;
  double least = square(0), most = 0.0;
  for (Eigen::Index i = kCount; i < count; i += kCount)
    if (const double each = square(i); each < least) {
      near = i;
      least = each;
    }
  const Eigen::Index first = std::clamp<Eigen::Index>(near - kCount / 2, 0, count - kCount);
  for (Eigen::Index i = first; i < first + kCount; ++i) most = std::max(most, square(i));
  return std::nextafter(most, std::numeric_limits<double>::infinity());
}

// The demonstrated speed: the mean of the nearest ones, by the inverse of distances plus a cell.
double MarchingPolicy::speed_at(const Vector3d& point) const {
  std::array<double, kNeighbours> squares;
  std::array<Eigen::Index, kNeighbours> nearest{};
  squares.fill(farther_than_nearest(point));
  for (Eigen::Index i = 0; i < positions_.cols(); ++i) {
    const double square = (positions_.col(i) - point).squaredNorm();
    if (!(square < squares.back())) continue;
    std::size_t k = kNeighbours - 1;
    for (; k > 0 && squares[k - 1] > square; --k) {
      squares[k] = squares[k - 1];
      nearest[k] = nearest[k - 1];
    }
    squares[k] = square;
    nearest[k] = i;
  }
  double sum = 0.0, weights = 0.0;
  for (std::size_t k = 0; k < kNeighbours; ++k) {
    const double weight = 1.0 / (std::sqrt(squares[k]) + cell_);  // 0 for those that are missing
    sum += weight * speeds_[nearest[k]];
    weights += weight;
  }
  return sum / weights;
}

DescentStatus MarchingPolicy::descend(const Vector3d& point, Vector3d& unit) const {
  const Vector3d at = (point - origin_).cwiseQuotient(spacing_);
  const Direction found = std::visit(
      [&](const auto* times) { return direction(grid_, times, {at[0], at[1], at[2]}); }, arrival_);
  unit = {found.unit[0], found.unit[1], found.unit[2]};
  return found.status;
}

DescentStatus MarchingPolicy::velocity_at(const Vector3d& point, Vector3d& velocity) const {
  double speed = speed_at(point);
  const Vector3d ahead = goal_ - point;
  const double left = ahead.norm(), rate = mean_speed_ / slowing_;
  if (barrier_ && barrier_->is_passed(point)) {
    // In the barrier the field has no gradient, nor in the cell beyond that needs one of it.
    const Vector3d before = point - spacing_.cwiseProduct(barrier_->normal);
    if (barrier_->contains(point) || barrier_->contains(before)) {
      velocity = speed * barrier_->normal;
      return DescentStatus::kOk;
    }
  } else if (left <= cell_) {  // the field means nothing within the goal's cell
    velocity = std::min(rate, speed / cell_) * ahead;
    return DescentStatus::kOk;
  } else {
    speed = std::min(speed, rate * left);
  }
  const DescentStatus status = descend(point, velocity);
  velocity *= speed;
  return status;
}

}  // namespace leadthrough
