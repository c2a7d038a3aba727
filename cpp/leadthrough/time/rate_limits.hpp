#pragma once

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

// One value a joint; infinite where there is none. Zero is for joints that do not move.
struct RateLimits {
  Eigen::VectorXd velocity, acceleration, jerk;
};

}  // namespace leadthrough
