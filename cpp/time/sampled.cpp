#include "time/sampled.hpp"

#include <algorithm>

namespace leadthrough {

using Eigen::Index;

Derivatives central_differences(const Eigen::Ref<const Eigen::VectorXd>& times,
                                const Eigen::Ref<const Rows>& positions,
                                const Eigen::Ref<const Rows>& beyond) {
  const Index n = positions.rows(), joints = positions.cols();
  Derivatives result{Rows(n, joints), Rows(n, joints)};
  const auto step = [&](Index k) {  // to sample k
    const Index inside = std::clamp<Index>(k, 1, n - 1);
    return times[inside] - times[inside - 1];
  };
  const auto row = [&](Index k) {
    return k < 0 ? beyond.data() : k < n ? positions.row(k).data() : beyond.row(1).data();
  };
  Eigen::VectorXd slope(joints);  // over the step to sample k
  for (Index j = 0; j < joints; ++j) slope[j] = (row(0)[j] - row(-1)[j]) / step(0);
  for (Index k = 0; k < n; ++k) {
    const double before = step(k), after = step(k + 1), both = before + after;
    const double* here = row(k);
    const double* next = row(k + 1);
    double* velocity = result.velocities.row(k).data();
    double* acceleration = result.accelerations.row(k).data();
    for (Index j = 0; j < joints; ++j) {
      const double ahead = (next[j] - here[j]) / after;
      velocity[j] = (after * slope[j] + before * ahead) / both;
      acceleration[j] = 2.0 * (ahead - slope[j]) / both;
      slope[j] = ahead;
    }
  }
  return result;
}

std::vector<Index> stops(const Eigen::Ref<const Rows>& positions,
                         const Eigen::Ref<const Rows>& velocities) {
  std::vector<Index> result;
  const Index joints = positions.cols();
  for (Index k = 1; k + 1 < positions.rows(); ++k) {
    const double* velocity = velocities.row(k).data();
    if (std::any_of(velocity, velocity + joints, [](double v) { return v != 0.0; })) continue;
    const double* here = positions.row(k).data();
    if (!std::equal(here, here + joints, positions.row(k - 1).data())) result.push_back(k);
  }
  return result;
}

Extent extent_of(const Eigen::Ref<const Rows>& rows) {
  Extent result{rows.row(0), rows.row(0)};
  for (Index k = 1; k < rows.rows(); ++k) {
    const double* row = rows.row(k).data();
    for (Index j = 0; j < rows.cols(); ++j) {
      result.least[j] = std::min(result.least[j], row[j]);
      result.largest[j] = std::max(result.largest[j], row[j]);
    }
  }
  return result;
}

}  // namespace leadthrough
