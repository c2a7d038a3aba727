#include "leadthrough/collision/corners.hpp"

#include <utility>

#include "leadthrough/base/constants.hpp"

namespace leadthrough {

using Eigen::Index;

Corners::Corners(Eigen::Matrix3Xd points)
    : points_(std::move(points)),
      fours_(static_cast<std::size_t>((points_.cols() + 2 * kCount - 1) / (2 * kCount) * 2)) {
  for (Index i = 0; i < static_cast<Index>(fours_.size()) * kCount; ++i)
    for (Index k = 0; k < 3; ++k)
      fours_[static_cast<std::size_t>(i / kCount)].axis[k][i % kCount] =
          points_(k, i < points_.cols() ? i : 0);
}

[[gnu::always_inline]] inline Index Corners::search_here(const Eigen::Vector3d& along) const {
  // Every other four by itself: a comparison waits for the one before.
  Values most[2] = {Values{} - kInfinity, Values{} - kInfinity};
  Numbers at[2] = {};
  for (std::size_t i = 0; i < fours_.size(); i += 2)
    for (std::size_t k = 0; k < 2; ++k) {
      const Values* axis = fours_[i + k].axis;
      const Values reach = axis[0] * along[0] + axis[1] * along[1] + axis[2] * along[2];
      const Numbers farther = reach > most[k];
      most[k] = farther ? reach : most[k];
      at[k] = farther ? static_cast<std::int64_t>(i + k) : at[k];
    }
  const Numbers second = (most[1] > most[0]) | ((most[1] == most[0]) & (at[1] < at[0]));
  most[0] = second ? most[1] : most[0];
  at[0] = second ? at[1] : at[0];
  int best = 0;
  for (int lane = 1; lane < kCount; ++lane)
    if (most[0][lane] > most[0][best] ||
        (most[0][lane] == most[0][best] && at[0][lane] < at[0][best]))
      best = lane;
  return at[0][best] * kCount + best;
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
