#pragma once

// The ranges of joints: values inside them, joints that wrap, and random
// configurations.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/ik/task.hpp"

namespace leadthrough {

// SplitMix64, Steele, Lea and Flood 2014: the standard library's distributions differ by vendor.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t stream) : state_(seed) {
    state_ = next() ^ (stream * 0xd1342543de82ef95U);
  }

  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

 private:
  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
};

// A joint with a range of a full revolution wraps instead of stopping at its limits.
inline bool wraps(const Chain& chain, int i) {
  return chain.periodic[static_cast<std::size_t>(i)] && chain.upper[i] - chain.lower[i] >= kTurn;
}

// Between two angles, whole turns left out; `std::remainder` takes ten times as long.
inline double apart_within_turn(double a, double b) {
  const double away = a - b;
  return std::abs(away - kTurn * std::nearbyint(away / kTurn));
}

// The multiple of 2 pi that brings an angle nearest to another one inside the limits.
inline double wrapped(double angle, double near, double lower, double upper) {
  angle += kTurn * std::round((near - angle) / kTurn);
  if (angle < lower) angle += kTurn * std::ceil((lower - angle) / kTurn);
  if (angle > upper) angle -= kTurn * std::ceil((angle - upper) / kTurn);
  return std::clamp(angle, lower, upper);
}

inline JointArray random_configuration(const Chain& chain, RandomStream& random) {
  JointArray q{};
  for (int i = 0; i < chain.joints(); ++i) {
    const auto [lower, upper] = sampled_range(chain, i);
    q[static_cast<std::size_t>(i)] = lower + random.uniform() * (upper - lower);
  }
  return q;
}

}  // namespace leadthrough
