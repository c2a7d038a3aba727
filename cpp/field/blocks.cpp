#include "field/blocks.hpp"

#include <algorithm>

namespace leadthrough {

std::vector<double> tube_speeds(const Blocks& blocks, const std::vector<Index>& numbers,
                                const std::vector<Tube>& tubes, double radius, double saturation) {
  std::vector<Point> points(numbers.size());
  std::transform(numbers.begin(), numbers.end(), points.begin(),
                 [&](Index number) { return blocks.centre(number); });
  std::vector<double> speeds(numbers.size(), 0.0);
  for (const Tube& tube : tubes) {
    const std::vector<double> away = path_distances(points, tube.path, radius + blocks.reach);
    for (std::size_t n = 0; n < speeds.size(); ++n) {
      const double nearest = std::max(away[n] - blocks.reach, 0.0);
      speeds[n] = std::max(speeds[n], tube.weight * std::max(1.0 - nearest / radius, 0.0));
    }
  }
  for (double& speed : speeds) speed = saturation + (1.0 - saturation) * speed;
  return speeds;
}

}  // namespace leadthrough
