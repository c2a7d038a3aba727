#include "leadthrough/collision/motion_bound.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/collision/scene.hpp"

namespace leadthrough::collision {

MovingValues reach_of_point(const Chain& chain, int frame, Eigen::Vector3d offset, double radius,
                            const MovingValues& extent) {
  MovingValues reach{};
  // Radius of a ball around the points, first about `offset`, then about each joint's origin.
  for (; frame > 0; frame = chain.parent_frame[index(frame - 1)]) {
    const std::size_t k = index(frame - 1);
    reach[k] = chain.prismatic[k] ? 1.0 : offset.head<2>().norm() + radius;
    radius += offset.norm() + (chain.prismatic[k] ? extent[k] : 0.0);
    offset = chain.fixed[k].position;
  }
  return reach;
}

std::vector<MovingValues> reaches(const CollisionScene& scene, const MovingValues& extent) {
  std::vector<MovingValues> result;
  for (std::size_t s = 0; s < scene.shapes.size(); ++s)
    result.push_back(reach_of_point(scene.chain, scene.frames[s],
                                    scene.shapes[s].T_frame_shape.position, scene.shapes[s].radius,
                                    extent));
  return result;
}

MovingValues sampled_extent(const Chain& chain) {
  MovingValues extent{};
  for (std::size_t k = 0; k < moving_count(chain); ++k) {
    const Drive& drive = chain.drives[k];
    const JointRange range = sampled_range(chain, drive.joint);
    extent[k] =
        std::abs(drive.multiplier) * std::max(std::abs(range.lower), std::abs(range.upper)) +
        std::abs(drive.offset);
  }
  return extent;
}

double pair_motion(const CollisionScene& scene, const std::vector<MovingValues>& reach,
                   const ShapePair& pair, const MovingValues& change) {
  const std::size_t a = index(pair.a), b = index(pair.b);
  double sum = 0.0;
  for_each_joint(scene.joints[a] & ~scene.joints[b],
                 [&](std::size_t k) { sum += change[k] * reach[a][k]; });
  for_each_joint(scene.joints[b] & ~scene.joints[a],
                 [&](std::size_t k) { sum += change[k] * reach[b][k]; });
  return sum;
}

}  // namespace leadthrough::collision
