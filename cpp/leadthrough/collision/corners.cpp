#include "leadthrough/collision/corners.hpp"

#include <utility>

#include "leadthrough/base/constants.hpp"

namespace leadthrough {

using Eigen::Index;

Corners::Corners(Eigen::Matrix3Xd points)
    : points_(std::move(points)),
      fours_(static_cast<std::size_t>((points_.cols() + kCount - 1) / kCount)) {
  for (Index i = 0; i < static_cast<Index>(fours_.size()) * kCount; ++i)
    for (Index k = 0; k < 3; ++k)
      fours_[static_cast<std::size_t>(i / kCount)].axis[k][i % kCount] =
          points_(k, i < points_.cols() ? i : 0);
}

[[gnu::always_inline]] inline Index Corners::search_here(const Eigen::Vector3d& along) const {
  Values most = Values{} - kInfinity;
  Numbers at{};
  for (std::size_t i = 0; i < fours_.size(); ++i) {
    const Values* axis = fours_[i].axis;
    const Values reach = axis[0] * along[0] + axis[1] * along[1] + axis[2] * along[2];
    const Numbers farther = reach > most;
    most = farther ? reach : most;
    at = farther ? static_cast<std::int64_t>(i) : at;
  }
  int best = 0;
  for (int lane = 1; lane < kCount; ++lane)
    if (most[lane] > most[best] || (most[lane] == most[best] && at[lane] < at[best])) best = lane;
  return at[best] * kCount + best;
}

#ifdef __x86_64__
[[gnu::target("avx2")]] Index Corners::search_wide(const Eigen::Vector3d& along) const {
  return search_here(along);
}
#endif

Index Corners::search(const Eigen::Vector3d& along) const { return search_here(along); }

Eigen::Vector3d Corners::farthest(const Eigen::Vector3d& along) const {
#ifdef __x86_64__
  static const bool kWide = __builtin_cpu_supports("avx2") != 0;
  if (kWide) return points_.col(search_wide(along));
#endif
  return points_.col(search(along));
}

}  // namespace leadthrough
