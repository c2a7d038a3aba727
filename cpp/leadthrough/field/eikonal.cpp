#include "leadthrough/field/eikonal.hpp"

#include "leadthrough/base/parallel.hpp"
#include "leadthrough/field/bucket_march.hpp"
#include "leadthrough/field/padded_field.hpp"
#include "leadthrough/field/sorted_march.hpp"

namespace leadthrough {

namespace {

template <typename Real, int D>
std::vector<Real> first_order(const Grid& grid, const Real* speed,
                              const std::vector<Source>& sources, Index stop) {
  PaddedField<Real, D> field(grid, speed);
  return field.has_cubes() ? run_march<BucketMarch<Real, D, true>>(field, sources, stop)
                           : run_march<BucketMarch<Real, D, false>>(field, sources, stop);
}

template <typename Real, int D>
std::vector<Real> second_order(const Grid& grid, const Real* speed,
                               const std::vector<Source>& sources, Index stop) {
  PaddedField<Real, D> field(grid, speed);
  return run_march<SortedMarch<Real, D, PaddedField<Real, D>>>(field, sources, stop);
}

}  // namespace

template <typename Real>
std::vector<Real> march_first_order(const Grid& grid, const Real* speed,
                                    const std::vector<Source>& sources, Index stop) {
  return grid.shape[0] == 1 ? first_order<Real, 2>(grid, speed, sources, stop)
                            : first_order<Real, 3>(grid, speed, sources, stop);
}

template <typename Real>
std::vector<Real> march_second_order(const Grid& grid, const Real* speed,
                                     const std::vector<Source>& sources, Index stop) {
  return grid.shape[0] == 1 ? second_order<Real, 2>(grid, speed, sources, stop)
                            : second_order<Real, 3>(grid, speed, sources, stop);
}

template <typename Real>
std::vector<Real> march(const Grid& grid, const MarchProblem<Real>& problem,
                        const MarchOptions& options) {
  const std::vector<Source> sources =
      options.source_radius > 0.0
          ? with_balls(grid, problem.speed, problem.sources, options.source_radius)
          : problem.sources;
  return options.order == 1 ? march_first_order(grid, problem.speed, sources, options.stop)
                            : march_second_order(grid, problem.speed, sources, options.stop);
}

template <typename Real>
std::vector<std::vector<Real>> march_batch(const Grid& grid,
                                           const std::vector<MarchProblem<Real>>& problems,
                                           const MarchOptions& options, int threads) {
  std::vector<std::vector<Real>> times(problems.size());
  for_each_index(problems.size(), threads,
                 [&](std::size_t n) { times[n] = march(grid, problems[n], options); });
  return times;
}

template <typename Real>
using Times = std::vector<Real>;

template Times<float> march_first_order(const Grid&, const float*, const std::vector<Source>&,
                                        Index);
template Times<double> march_first_order(const Grid&, const double*, const std::vector<Source>&,
                                         Index);
template Times<float> march_second_order(const Grid&, const float*, const std::vector<Source>&,
                                         Index);
template Times<double> march_second_order(const Grid&, const double*, const std::vector<Source>&,
                                          Index);
template Times<float> march(const Grid&, const MarchProblem<float>&, const MarchOptions&);
template Times<double> march(const Grid&, const MarchProblem<double>&, const MarchOptions&);
template std::vector<Times<float>> march_batch(const Grid&, const std::vector<MarchProblem<float>>&,
                                               const MarchOptions&, int);
template std::vector<Times<double>> march_batch(const Grid&,
                                                const std::vector<MarchProblem<double>>&,
                                                const MarchOptions&, int);

}  // namespace leadthrough
