#pragma once

// Parts shared by single orientations of a pose primitive and by batches of them.

#include "leadthrough/base/polynomial.hpp"
#include "leadthrough/dmp/orientation_curve.hpp"

namespace leadthrough::dmp {

// Of cos(x) and sin(x) / x, in powers of x^2; exact to rounding below this square of half an angle.
inline constexpr double kSeriesSquare = 0.07;  // rad^2
inline constexpr double kCosine[] = {
    1.0, -1.0 / 2.0, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40320.0, -1.0 / 3628800.0, 1.0 / 479001600.0};
inline constexpr double kSinc[] = {1.0,           -1.0 / 6.0,     1.0 / 120.0,
                                   -1.0 / 5040.0, 1.0 / 362880.0, -1.0 / 39916800.0};

// Position on the curve's parameter, and its rate.
struct Progress {
  double share, speed;
};

// The parameter on the curve. Beyond phase 1 it is constant, or continues.
Progress place_on(const Curve& curve, double phase);

// The offset's rotation at a phase.
so3::Quaternion offset_at(const Path& offset, double phase);

}  // namespace leadthrough::dmp
