#include "leadthrough/dmp/orientation_curve.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/dmp/orientation_curve_parts.hpp"
#include "leadthrough/rotation/curve.hpp"

namespace leadthrough::dmp {

namespace {

using so3::Quaternion;
using so3::Vector3;

// Offsets within this of pi have two shortest rotations, of which a rule selects one.
constexpr double kHalfTurn = 1e-9;  // rad

// so3::exp without a root, sine and cosine: the curve's steps and the coordinates are short.
Quaternion short_exp(const Vector3& vector) {
  const double h = 0.25 * vector.squaredNorm();
  if (!(h < kSeriesSquare)) return so3::exp(vector);
  const double scale = 0.5 * short_sinc(h);
  return {short_cosine(h), scale * vector[0], scale * vector[1], scale * vector[2]};
}

Vector3 rotate(const Quaternion& q, const Vector3& v) {
  const Vector3 u = q.tail<3>();
  const Vector3 twice = 2.0 * u.cross(v);
  return v + q[0] * twice + u.cross(twice);
}

// A product of rotations, built from the left. `rate` is a factor's own angular velocity, in the
// base frame of that factor.
struct Still {
  Quaternion orientation{1.0, 0.0, 0.0, 0.0};

  template <typename Rate>
  void times(const Quaternion& factor, const Rate&) {
    orientation = so3::compose(orientation, factor);
  }
};

struct Moving {
  RotationState state{Quaternion(1.0, 0.0, 0.0, 0.0), Vector3::Zero()};

  template <typename Rate>
  void times(const Quaternion& factor, const Rate& rate) {
    state.velocity += rotate(state.orientation, rate());
    state.orientation = so3::compose(state.orientation, factor);
  }
};

template <typename Product>
void turn_by_offset(const Path& offset, double phase, Product& product) {
  if (offset.empty()) return;
  const double* c = nullptr;
  const double s = place_in_piece(offset, phase, &c);
  Vector3 vector = Eigen::Map<const Vector3>(c + 15);
  Vector3 slope = Vector3::Zero();
  for (Eigen::Index power = 4; power >= 0; --power) {
    slope = slope * s + vector;
    vector = vector * s + Eigen::Map<const Vector3>(c + 3 * power);
  }
  const bool moves = phase < offset.end();
  product.times(so3::exp(vector), [&]() -> Vector3 {
    return moves ? Vector3(so3::left_jacobian(vector) * slope) : Vector3(Vector3::Zero());
  });
}

template <typename Product>
void turn_along(const Curve& curve, double phase, Product& product) {
  const Eigen::Index intervals = curve.controls.rows() - 3;
  const Progress place = place_on(curve, phase);
  const auto i = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(place.share), 0, intervals - 1);
  const double s = place.share - static_cast<double>(i);
  const double r = 1.0 - s;
  // The cumulative basis and its derivative.
  const double shares[] = {1.0 - r * r * r / 6.0, (1.0 + s * (3.0 + s * (3.0 - 2.0 * s))) / 6.0,
                           s * s * s / 6.0};
  const double rises[] = {0.5 * r * r, 0.5 + s * r, 0.5 * s * s};
  product.times(curve.controls.row(i), []() -> Vector3 { return Vector3::Zero(); });
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Vector3 step = curve.steps.row(i + k);
    product.times(short_exp(shares[k] * step),
                  [&]() -> Vector3 { return place.speed * rises[k] * step; });
  }
}

template <typename Product>
void turn_by_coordinates(Representation representation, const Vector3& value, const Vector3& slope,
                         Product& product) {
  if (representation == Representation::kRotationVector) {
    product.times(short_exp(value), [&]() -> Vector3 { return so3::left_jacobian(value) * slope; });
    return;
  }
  const Eigen::Index axes[] = {2, 1, 2};
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Vector3 axis = Vector3::Unit(axes[k]);
    product.times(so3::exp(value[k] * axis), [&]() -> Vector3 { return slope[k] * axis; });
  }
}

template <typename Product>
Product reference(const Curve& curve, const Path& offset, double phase) {
  Product product;
  turn_by_offset(offset, phase, product);
  turn_along(curve, phase, product);
  return product;
}

// Either sign of a quaternion is the same rotation.
Vector3 nearest_log(const Quaternion& q, const Vector3& near) {
  return so3::nearest_log(q[0] < 0.0 ? Quaternion(-q) : q, near, kTurn);
}

Vector3 nearest_angles(const Quaternion& q, const Vector3& near) {
  const double together = std::atan2(q[3], q[0]);  // (first + third) / 2
  const double apart = std::atan2(-q[1], q[2]);    // (first - third) / 2
  const double second = 2.0 * std::atan2(std::hypot(q[1], q[2]), std::hypot(q[0], q[3]));
  Vector3 angles(together + apart, second, together - apart);
  for (const Eigen::Index k : {0, 2})
    angles[k] += kTurn * std::round((near[k] - angles[k]) / (kTurn));
  return angles;
}

so3::Matrix3 zyz_jacobian(const Vector3& angles) {
  so3::Matrix3 columns;
  for (Eigen::Index k = 0; k < 3; ++k) {
    Moving product;
    turn_by_coordinates(Representation::kZyz, angles, Vector3::Unit(k), product);
    columns.col(k) = product.state.velocity;
  }
  return columns;
}

// Of the coordinates, for an angular velocity of E(value) in its own base frame. Next to gimbal
// lock the least-squares solution.
Vector3 slope_of(Representation representation, const Vector3& value, const Vector3& velocity) {
  if (representation == Representation::kRotationVector)
    return so3::left_jacobian_inverse(value) * velocity;
  constexpr double kLocked = 1e-15;  // sine of the middle angle
  const so3::Matrix3 axes = zyz_jacobian(value);
  // The middle axis is orthogonal to the others.
  const double cosine = axes.col(0).dot(axes.col(2));
  const Vector3 across = axes.col(2) - cosine * axes.col(0);
  const double about = axes.col(0).dot(velocity), square = across.squaredNorm();
  const double last = square > kLocked * kLocked ? across.dot(velocity) / square
                                                 : 0.5 * std::copysign(about, cosine * about);
  return {about - cosine * last, axes.col(1).dot(velocity), last};
}

}  // namespace

Progress place_on(const Curve& curve, double phase) {
  const Eigen::Index intervals = curve.speeds.size() - 1;
  const auto count = static_cast<double>(intervals);
  const bool ends = curve.canonical == Canonical::kDiscrete;
  if (ends && phase >= 1.0) return {curve.covered[intervals], 0.0};
  const double at = count * (phase - (ends ? 0.0 : std::floor(phase)));
  const auto node = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(at), 0, intervals - 1);
  const double share = at - static_cast<double>(node);
  const double left = curve.speeds[node];
  const double rise = curve.speeds[node + 1] - left;
  return {curve.covered[node] + share * (left + 0.5 * share * rise) / count, left + share * rise};
}

Quaternion offset_at(const Path& offset, double phase) {
  Still product;
  turn_by_offset(offset, phase, product);
  return product.orientation;
}

Vector3 offset_between(const Quaternion& wanted, const Quaternion& demonstrated,
                       const Vector3& near) {
  Quaternion rotation = so3::compose(wanted, so3::inverse(demonstrated));
  if (std::abs(rotation[0]) < 0.5 * kHalfTurn) {
    const Vector3 axis = rotation.tail<3>();
    const double leading = std::abs(axis[0]) > kHalfTurn   ? axis[0]
                           : std::abs(axis[1]) > kHalfTurn ? axis[1]
                                                           : axis[2];
    if (leading < 0.0) rotation = -rotation;
    rotation[0] = std::abs(rotation[0]);
  }
  return nearest_log(rotation, near);
}

RotationState rotation_at(const Curve& curve, const Path& offset, double phase,
                          const Vector3& value, const Vector3& slope) {
  Moving product = reference<Moving>(curve, offset, phase);
  turn_by_coordinates(curve.representation, value, slope, product);
  return product.state;
}

Coordinates coordinates_of(const Curve& curve, const Path& offset, double phase,
                           const RotationState& state, const Vector3& near) {
  const RotationState base = reference<Moving>(curve, offset, phase).state;
  const Quaternion back = so3::inverse(base.orientation);
  const Quaternion relative = so3::compose(back, state.orientation);
  const Vector3 value = curve.representation == Representation::kRotationVector
                            ? nearest_log(relative, near)
                            : nearest_angles(relative, near);
  return {value,
          slope_of(curve.representation, value, rotate(back, state.velocity - base.velocity))};
}

Vector3 coordinate_push(const Curve& curve, const Path& offset, double phase, const Vector3& value,
                        const Vector3& angular) {
  const Quaternion base = reference<Still>(curve, offset, phase).orientation;
  return slope_of(curve.representation, value, rotate(so3::inverse(base), angular));
}

Quaternion orientation_at(const Curve& curve, const Path& offset, double phase,
                          const Vector3& value) {
  Still product = reference<Still>(curve, offset, phase);
  turn_by_coordinates(curve.representation, value, Vector3::Zero(), product);
  // It is within rounding of unit length: one Newton step normalises it.
  const double excess = product.orientation.squaredNorm() - 1.0;
  return product.orientation * (1.0 - 0.5 * excess);
}

}  // namespace leadthrough::dmp
