#include "leadthrough/field/sparse_distance.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/field/lower_envelope.hpp"

namespace leadthrough {

namespace {

// Squared distances propagate along the runs of adjacent cells along an axis. A target at the end
// of a run is nearer to all of it than any cell beyond.
void transform_runs(const CellSet& set, int axis, Outside outside, std::vector<double>& squared) {
  using Place = CellSet::Place;
  const Index most = set.grid().shape[axis] + 2;
  LowerEnvelope envelope(most, set.grid().spacing[axis]);
  std::vector<double> run;
  run.reserve(static_cast<std::size_t>(most));
  const auto ends_at_target = [&](Place place, int side) {
    return outside == Outside::kTarget && set.has_room(place, axis, side);
  };
  for (Place first = 0; first < set.missing(); ++first) {
    check_interrupt(first);
    if (set.next(first, axis, -1) != set.missing()) continue;
    run.clear();
    if (ends_at_target(first, -1)) run.push_back(0.0);
    const std::size_t lead = run.size();
    Place last = first;
    for (Place at = first; at != set.missing(); at = set.next(at, axis, 1)) {
      run.push_back(squared[at]);
      last = at;
    }
    if (ends_at_target(last, 1)) run.push_back(0.0);
    envelope.transform(run.data(), static_cast<Index>(run.size()));
    const double* from = run.data() + lead;
    for (Place at = first; at != set.missing(); at = set.next(at, axis, 1)) squared[at] = *from++;
  }
}

}  // namespace

std::vector<double> distance_transform(const CellSet& set, const std::uint8_t* mask,
                                       Outside outside) {
  std::vector<double> result(set.size());
  std::transform(mask, mask + set.size(), result.begin(),
                 [](std::uint8_t target) { return target ? 0.0 : kInfinity; });
  for (int axis = 2; axis >= 0; --axis)
    if (set.grid().shape[axis] > 1) transform_runs(set, axis, outside, result);
  for (double& value : result) value = std::sqrt(value);
  return result;
}

}  // namespace leadthrough
