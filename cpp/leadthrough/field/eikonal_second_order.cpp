#include <vector>

#include "leadthrough/field/eikonal.hpp"
#include "leadthrough/field/padded_field.hpp"
#include "leadthrough/field/sorted_march.hpp"

namespace leadthrough {

namespace {

template <typename Real, int D>
std::vector<Real> second_order(const Grid& grid, const Real* speed,
                               const std::vector<Source>& sources, Index stop) {
  PaddedField<Real, D> field(grid, speed);
  return run_march<SortedMarch<Real, D, PaddedField<Real, D>>>(field, sources, stop);
}

}  // namespace

template <typename Real>
std::vector<Real> march_second_order(const Grid& grid, const Real* speed,
                                     const std::vector<Source>& sources, Index stop) {
  return grid.shape[0] == 1 ? second_order<Real, 2>(grid, speed, sources, stop)
                            : second_order<Real, 3>(grid, speed, sources, stop);
}

template std::vector<float> march_second_order(const Grid&, const float*,
                                               const std::vector<Source>&, Index);
template std::vector<double> march_second_order(const Grid&, const double*,
                                                const std::vector<Source>&, Index);

}  // namespace leadthrough
