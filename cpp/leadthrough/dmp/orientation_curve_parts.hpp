#pragma once

// Parts shared by single orientations of a pose primitive and by batches of them.

#include "leadthrough/base/polynomial.hpp"
#include "leadthrough/dmp/orientation_curve.hpp"

namespace leadthrough::dmp {

// Below this square h of half an angle, few terms give its cosine and sine to rounding.
inline constexpr double kSeriesSquare = 0.07;  // rad^2

template <typename Number>
Number short_cosine(const Number& h) {
  return polynomial<7>(kCosine, h);
}

// sin(x) / x.
template <typename Number>
Number short_sinc(const Number& h) {
  return polynomial<6>(kSinc, h);
}

// Position on the curve's parameter, and its rate.
struct Progress {
  double share, speed;
};

// The parameter on the curve. Beyond phase 1 it is constant, or continues.
Progress place_on(const Curve& curve, double phase);

// The offset's rotation at a phase.
so3::Quaternion offset_at(const Path& offset, double phase);

}  // namespace leadthrough::dmp
