#pragma once

// Distances between sampled curves of any two lengths, one point a row, over all monotone pairings
// of their samples that join first to first and last to last. The distances pair a row of the
// longer curve with rows of the shorter one at most `band` from the diagonal (Sakoe and Chiba
// 1978).

#include <Eigen/Core>
#include <cstdint>
#include <limits>

namespace leadthrough {

using Points = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Pairs = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 2, Eigen::RowMajor>;

constexpr Eigen::Index kWholeTable = std::numeric_limits<Eigen::Index>::max();

// Dynamic time warping: the least sum of distances between paired samples (Sakoe and Chiba 1978,
// symmetric steps of weight one). Both curves need a point and the same dimension.
double dtw_distance(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b,
                    Eigen::Index band = kWholeTable);

// The optimal pairing of dynamic time warping: pairs of samples of a and b, first to last. Ties go
// to the step along both curves. Needs one byte for each pair of samples.
Pairs dtw_path(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b);

// Discrete Frechet distance: the least largest distance between paired samples (Eiter and Mannila
// 1994). Both curves need a point and the same dimension.
double frechet_distance(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b,
                        Eigen::Index band = kWholeTable);

}  // namespace leadthrough
