#pragma once

// Distances between sampled curves of any two lengths, one point a row, over all monotone pairings
// of their samples that join first to first and last to last.

#include <Eigen/Core>

namespace leadthrough {

using Points = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Dynamic time warping: the least sum of distances between paired samples (Sakoe and Chiba 1978,
// symmetric steps of weight one). Both curves need a point and the same dimension.
double dtw_distance(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b);

// Discrete Frechet distance: the least largest distance between paired samples (Eiter and Mannila
// 1994). Both curves need a point and the same dimension.
double frechet_distance(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b);

}  // namespace leadthrough
