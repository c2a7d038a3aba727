#pragma once

// Collision-free paths between configurations: two trees grow towards each other (RRT-Connect,
// Kuffner and LaValle 2000) on edges that are certified all along, then the path is shortened.

#include <cstdint>

#include "leadthrough/collision/edges.hpp"

namespace leadthrough {

struct ConnectOptions {
  std::uint64_t seed = 0;
  long steps = 200000;           // at most so many edges are tested while the trees grow
  Eigen::VectorXd lower, upper;  // bounds of the joints that are sampled
};

// Configurations in rows from the start to one of the goals, straight in the joints in between;
// empty if none was found.
Rows connect(const WholeArm& arm, const Eigen::VectorXd& start, const RowsRef& goals,
             const ConnectOptions& options);

}  // namespace leadthrough
