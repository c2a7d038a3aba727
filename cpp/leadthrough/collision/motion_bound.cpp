#include "leadthrough/collision/motion_bound.hpp"

namespace leadthrough::collision {

std::vector<MovingValues> reaches(const CollisionScene& scene, const MovingValues& extent) {
  std::vector<MovingValues> result(scene.shapes.size(), MovingValues{});
  const Chain& chain = scene.chain;
  for (std::size_t s = 0; s < scene.shapes.size(); ++s) {
    const BodyShape& shape = scene.shapes[s];
    // Radius of a bounding ball of the shape, first about its own origin, then about each joint's.
    double radius = shape.radius;
    Eigen::Vector3d offset = shape.T_frame_shape.position;
    for (auto k = static_cast<std::size_t>(scene.joints[s]); k-- > 0;) {
      result[s][k] = chain.prismatic[k] ? 1.0 : offset.head<2>().norm() + radius;
      radius += offset.norm() + (chain.prismatic[k] ? extent[k] : 0.0);
      offset = chain.fixed[k].position;
    }
  }
  return result;
}

double pair_motion(const CollisionScene& scene, const std::vector<MovingValues>& reach,
                   const ShapePair& pair, const MovingValues& change) {
  const auto a = static_cast<std::size_t>(pair.a);
  const auto b = static_cast<std::size_t>(pair.b);
  double sum = 0.0;
  for (auto k = static_cast<std::size_t>(scene.joints[a]);
       k < static_cast<std::size_t>(scene.joints[b]); ++k)
    sum += change[k] * reach[b][k];
  return sum;
}

}  // namespace leadthrough::collision
