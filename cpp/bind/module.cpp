#include <cstddef>
#include <cstdlib>

#include "bind/parts.hpp"

namespace {

// glibc returns freed memory to the system where it is more than twice the largest block freed so
// far, and to get it anew takes as long as to compute in it: a tenth of a plan's time.
void keep_freed_memory() {
  constexpr std::size_t kMax = std::size_t{1} << 22;
  void* volatile block = std::malloc(kMax);
  std::free(block);
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  module.doc() = "Numeric kernels of leadthrough; arguments are checked by the Python layer above.";
  keep_freed_memory();
  leadthrough::bind_alignment(module);
  leadthrough::bind_chain(module);
  leadthrough::bind_shapes(module);  // before those that take shapes
  leadthrough::bind_walls(module);
  leadthrough::bind_speeds(module);
  leadthrough::bind_collision(module);
  leadthrough::bind_dmp(module);
  leadthrough::bind_dynamics(module);
  leadthrough::bind_field(module);
  leadthrough::bind_finite(module);
  leadthrough::bind_gaussian(module);
  leadthrough::bind_guard(module);
  leadthrough::bind_ik(module);
  leadthrough::bind_jacobian(module);
  leadthrough::bind_jerk_filter(module);
  leadthrough::bind_path(module);
  leadthrough::bind_priority(module);
  leadthrough::bind_so3(module);
  leadthrough::bind_spline_fit(module);
  leadthrough::bind_time_law(module);
  leadthrough::bind_tracking(module);
}
