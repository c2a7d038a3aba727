#pragma once

// Three joints with skew axes that bring a point to a goal: a trigonometric equation of degree two
// in the third angle (Pieper 1968), which has up to four roots.

#include "leadthrough/base/constants.hpp"
#include "leadthrough/ik/closed_form.hpp"

namespace leadthrough {

// c[0] + c[1] cos + c[2] sin + c[3] cos 2 + c[4] sin 2, scaled to coefficients of at most 1.
struct SecondDegree {
  std::array<double, 5> c;

  double value(double x) const {
    return c[0] + c[1] * std::cos(x) + c[2] * std::sin(x) + c[3] * std::cos(2 * x) +
           c[4] * std::sin(2 * x);
  }
  double slope(double x) const {
    return c[2] * std::cos(x) - c[1] * std::sin(x) +
           2 * (c[4] * std::cos(2 * x) - c[3] * std::sin(2 * x));
  }
};

// The zero of a function between two arguments where it has opposite signs.
template <typename Function>
double zero_between(double lower, double upper, const Function& function) {
  const bool rising = function(upper) > 0.0;
  constexpr int kHalvings = 54;  // to the last bit of a double
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (lower + upper);
    ((function(middle) > 0.0) == rising ? upper : lower) = middle;
  }
  return 0.5 * (lower + upper);
}

// Extrema split the circle into parts with at most one root each; those near 0 are tangents.
template <typename Visit>
void each_root(const SecondDegree& f, Walk& walk, const Visit& visit) {
  constexpr int kParts = 64;  // more than the four extrema could hide between
  std::array<double, 4> extrema;
  std::size_t count = 0;
  const auto slope = [&](double x) { return f.slope(x); };
  for (int k = 0; k < kParts; ++k) {
    const double lower = kTurn * k / kParts, upper = kTurn * (k + 1) / kParts;
    if ((slope(lower) > 0.0) != (slope(upper) > 0.0) && count < extrema.size())
      extrema[count++] = zero_between(lower, upper, slope);
  }
  const int branch = walk.branch;
  const double missed = walk.missed;
  for (std::size_t k = 0; k < count; ++k) {
    const double here = extrema[k];
    const double next = k + 1 < count ? extrema[k + 1] : extrema[0] + kTurn;
    walk.branch = 8 * branch + static_cast<int>(2 * k);
    const double height = std::abs(f.value(here));
    walk.near = walk.near || height < walk.margin;
    walk.missed = missed + std::max(height - walk.slack, 0.0);
    if (height <= walk.slack + walk.reach) visit(here);
    walk.missed = missed;
    ++walk.branch;
    if ((f.value(here) > 0.0) != (f.value(next) > 0.0))
      visit(zero_between(here, next, [&](double x) { return f.value(x); }));
  }
  walk.branch = branch;
}

// An affine function of the third angle's cosine and sine.
struct Affine {
  double constant, cosine, sine;
  double at(Angle angle) const { return constant + cosine * angle.cosine + sine * angle.sine; }
  Affine scaled(double factor) const { return {factor * constant, factor * cosine, factor * sine}; }
};

// Adds weight f^2.
inline void add_square(const Affine& f, double weight, SecondDegree& sum) {
  sum.c[0] += weight * (f.constant * f.constant + 0.5 * (f.cosine * f.cosine + f.sine * f.sine));
  sum.c[1] += weight * 2 * f.constant * f.cosine;
  sum.c[2] += weight * 2 * f.constant * f.sine;
  sum.c[3] += weight * 0.5 * (f.cosine * f.cosine - f.sine * f.sine);
  sum.c[4] += weight * f.cosine * f.sine;
}

template <typename Visit>
void each_general_shoulder(const std::array<Screw, 7>& screws, const Eigen::Vector3d& x,
                           const Eigen::Vector3d& goal, Walk& walk, const Visit& visit) {
  const Screw &first = screws[0], &second = screws[1], &third = screws[2];
  // The common perpendicular of axes 1 and 2, from a to b on them.
  const Eigen::Vector3d along = first.axis.cross(second.axis), apart = second.point - first.point;
  const double sine_squared = along.squaredNorm();
  const Eigen::Vector3d a =
      first.point + first.axis * (apart.cross(second.axis).dot(along) / sine_squared);
  const Eigen::Vector3d b =
      second.point + second.axis * (apart.cross(first.axis).dot(along) / sine_squared);
  const Eigen::Vector3d ex = along / std::sqrt(sine_squared), ey = second.axis.cross(ex);
  const double distance = (b - a).dot(ex), tilt = first.axis.dot(ey),
               cosine = first.axis.dot(second.axis);
  // u, from b to the point that joint 3 has moved, by that joint's angle.
  const Eigen::Vector3d arm = x - third.point;
  const Eigen::Vector3d u0 = third.point - b + third.axis * third.axis.dot(arm);
  const Eigen::Vector3d u1 = arm - third.axis * third.axis.dot(arm), u2 = third.axis.cross(arm);
  const Affine squared{u0.squaredNorm() + u1.squaredNorm(), 2 * u0.dot(u1), 2 * u0.dot(u2)};
  const Affine height{second.axis.dot(u0), second.axis.dot(u1), second.axis.dot(u2)};
  const Eigen::Vector3d from_first = goal - a;
  // Joint 2 turns the part of u across its axis into X ex + Y ey; both follow from joint 3, and
  // X^2 + Y^2 is that part's squared length.
  Affine X = squared.scaled(-0.5), Y = height.scaled(-cosine);
  X.constant += 0.5 * (from_first.squaredNorm() - distance * distance);
  Y.constant += first.axis.dot(from_first);
  SecondDegree f{};
  add_square(X, tilt * tilt, f);
  add_square(Y, distance * distance, f);
  add_square(height, distance * distance * tilt * tilt, f);
  const Affine rest = squared.scaled(-distance * distance * tilt * tilt);
  f.c[0] += rest.constant, f.c[1] += rest.cosine, f.c[2] += rest.sine;
  const double scale =
      1.0 / std::abs(*std::max_element(f.c.begin(), f.c.end(), [](double left, double right) {
        return std::abs(left) < std::abs(right);
      }));
  for (double& each : f.c) each *= scale;
  each_root(f, walk, [&](double root) {
    const Angle q3{std::cos(root), std::sin(root)};
    const Eigen::Vector3d u = u0 + q3.cosine * u1 + q3.sine * u2;
    const Eigen::Vector3d across = (X.at(q3) / distance) * ex + (Y.at(q3) / tilt) * ey;
    each_rotation(second.axis, u, across, walk, [&](Angle q2) {
      each_rotation(first.axis, rotate(second.axis, q2, u) + b - a, from_first, walk,
                    [&](Angle q1) { visit(std::array<Angle, 3>{q1, q2, q3}); });
    });
  });
}

}  // namespace leadthrough
