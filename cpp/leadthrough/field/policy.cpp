#include "leadthrough/field/policy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

using Vector3 = Eigen::Vector3d;

constexpr std::size_t kNeighbours = 8;    // whose speeds count at a point
constexpr double kPart = 0.1;             // cells that one move is long, at most
constexpr double kStraight = 1.0 - 1e-9;  // cosine to the goal's direction near it
constexpr double kTiny = 1e-300;          // instead of a length or speed of 0

double largest_spacing(const Grid& grid) {
  return *std::max_element(grid.spacing.begin(), grid.spacing.end());
}

// The demonstrated speed: the mean of the nearest ones, by the inverse of distances plus a cell.
double speed_at(const Policy& policy, const Vector3& point, double cell) {
  std::array<double, kNeighbours> squares;
  std::array<Eigen::Index, kNeighbours> nearest{};
  squares.fill(std::numeric_limits<double>::infinity());
  for (Eigen::Index i = 0; i < policy.positions.cols(); ++i) {
    const double square = (policy.positions.col(i) - point).squaredNorm();
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
    const double weight = 1.0 / (std::sqrt(squares[k]) + cell);  // 0 for those that are missing
    sum += weight * policy.speeds[nearest[k]];
    weights += weight;
  }
  return sum / weights;
}

struct Parts {
  double along, across;
};

Parts parts_of(const StartBarrier& barrier, const Vector3& point) {
  const Vector3 away = point - barrier.middle;
  const double along = away.dot(barrier.normal);
  return {along, (away - along * barrier.normal).norm()};
}

bool contains(const StartBarrier& barrier, const Vector3& point) {
  const Parts parts = parts_of(barrier, point);
  return std::abs(parts.along) <= barrier.thickness && parts.across <= barrier.width;
}

// Beyond the barrier, where the motion starts, or beside it.
bool is_passed(const StartBarrier& barrier, const Vector3& point) {
  const Parts parts = parts_of(barrier, point);
  return parts.along > -barrier.thickness || parts.across > barrier.width;
}

// The point's cell, or one that its gradient needs, belongs to the barrier.
bool is_at(const StartBarrier& barrier, const Grid& grid, const Vector3& point) {
  const Vector3 spacing(grid.spacing[0], grid.spacing[1], grid.spacing[2]);
  return contains(barrier, point) ||
         contains(barrier, point - spacing.cwiseProduct(barrier.normal));
}

DescentStatus down(const Policy& policy, const Vector3& point, Vector3& unit) {
  Coordinates at{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    at[axis] = (point[i] - policy.origin[i]) / policy.grid.spacing[axis];
  }
  const Direction found = std::visit(
      [&](const auto* arrival) { return direction(policy.grid, arrival, at); }, policy.arrival);
  unit = {found.unit[0], found.unit[1], found.unit[2]};
  return found.status;
}

}  // namespace

DescentStatus velocity_at(const Policy& policy, const Vector3& point, Vector3& velocity) {
  const double cell = largest_spacing(policy.grid);
  double speed = speed_at(policy, point, cell);
  const Vector3 ahead = policy.goal - point;
  const double left = ahead.norm(), rate = policy.mean_speed / policy.slowing;
  if (policy.barrier && is_passed(*policy.barrier, point)) {
    if (is_at(*policy.barrier, policy.grid, point)) {
      velocity = speed * policy.barrier->normal;
      return DescentStatus::kOk;
    }
  } else if (left <= cell) {  // the field means nothing within the goal's cell
    velocity = std::min(rate, speed / cell) * ahead;
    return DescentStatus::kOk;
  } else {
    speed = std::min(speed, rate * left);
  }
  const DescentStatus status = down(policy, point, velocity);
  velocity *= speed;
  return status;
}

DescentStatus follow(const Policy& policy, double span, Vector3& point) {
  const double cell = largest_spacing(policy.grid);
  while (span > 0.0) {
    check_interrupt();
    Vector3 velocity;
    const DescentStatus status = velocity_at(policy, point, velocity);
    if (status != DescentStatus::kOk) return status;
    const Vector3 ahead = policy.goal - point;
    const double left = ahead.norm(), speed = velocity.norm();
    if (left <= cell && velocity.dot(ahead) >= kStraight * left * speed) {
      point -= std::expm1(-span * speed / std::max(left, kTiny)) * ahead;
      break;
    }
    const double part = std::min(span, kPart * cell / std::max(speed, kTiny));
    point += part * velocity;
    span -= part;
  }
  return DescentStatus::kOk;
}

}  // namespace leadthrough
