#include "leadthrough/field/eikonal.hpp"

#include "leadthrough/field/bucket_march.hpp"
#include "leadthrough/field/padded_field.hpp"

namespace leadthrough {

namespace {

template <typename Real, int D>
std::vector<Real> first_order(const Grid& grid, const Real* speed,
                              const std::vector<Source>& sources, Index stop) {
  PaddedField<Real, D> field(grid, speed);
  return field.has_cubes() ? run_march<BucketMarch<Real, D, true>>(field, sources, stop)
                           : run_march<BucketMarch<Real, D, false>>(field, sources, stop);
}

}  // namespace

template <typename Real>
std::vector<Real> march_first_order(const Grid& grid, const Real* speed,
                                    const std::vector<Source>& sources, Index stop) {
  return grid.shape[0] == 1 ? first_order<Real, 2>(grid, speed, sources, stop)
                            : first_order<Real, 3>(grid, speed, sources, stop);
}

template std::vector<float> march_first_order(const Grid&, const float*, const std::vector<Source>&,
                                              Index);
template std::vector<double> march_first_order(const Grid&, const double*,
                                               const std::vector<Source>&, Index);

}  // namespace leadthrough
