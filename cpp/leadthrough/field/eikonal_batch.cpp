#include "leadthrough/base/parallel.hpp"
#include "leadthrough/field/eikonal.hpp"

namespace leadthrough {

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

template std::vector<float> march(const Grid&, const MarchProblem<float>&, const MarchOptions&);
template std::vector<double> march(const Grid&, const MarchProblem<double>&, const MarchOptions&);
template std::vector<std::vector<float>> march_batch(const Grid&,
                                                     const std::vector<MarchProblem<float>>&,
                                                     const MarchOptions&, int);
template std::vector<std::vector<double>> march_batch(const Grid&,
                                                      const std::vector<MarchProblem<double>>&,
                                                      const MarchOptions&, int);

}  // namespace leadthrough
