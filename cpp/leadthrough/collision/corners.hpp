#pragma once

// The corners of a convex hull, four at once by the compiler's vectors: distances ask many times
// for the farthest one. The same bits with any instruction set, as in lanes.hpp.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace leadthrough {

class Corners {
 public:
  explicit Corners(Eigen::Matrix3Xd points);

  const Eigen::Matrix3Xd& points() const { return points_; }
  // Along a direction; of several the first.
  Eigen::Vector3d farthest(const Eigen::Vector3d& along) const;

 private:
  static constexpr int kCount = 4;
  using Values = double __attribute__((vector_size(8 * kCount)));
  using Numbers = std::int64_t __attribute__((vector_size(8 * kCount)));
  struct Four {
    Values axis[3];
  };

  // The same code for each instruction set.
  Eigen::Index search(const Eigen::Vector3d& along) const;
  Eigen::Index search_wide(const Eigen::Vector3d& along) const;
  Eigen::Index search_here(const Eigen::Vector3d& along) const;

  Eigen::Matrix3Xd points_;
  std::vector<Four> fours_;  // an even number, filled up with the first corner
};

}  // namespace leadthrough
