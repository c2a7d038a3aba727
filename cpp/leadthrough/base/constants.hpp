#pragma once

#include <limits>

namespace leadthrough {

constexpr double kPi = 3.14159265358979323846;
constexpr double kTurn = 2.0 * kPi;  // rad
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kTooFar = 1e100;  // m; sums of squares beyond may be infinite

}  // namespace leadthrough
