#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "leadthrough/time/jerk_filter.hpp"

namespace py = pybind11;

namespace leadthrough {

void bind_jerk_filter(py::module_& module) {
  using AxisColumnsRef = Eigen::Ref<const AxisColumns>;
  module.def(
      "resting_places",
      [](const AxisColumnsRef& states, const AxisColumnsRef& limits) {
        const Unlocked unlocked;
        return resting_places({states, limits});
      },
      py::arg("states").noconvert(), py::arg("limits").noconvert());
  module.def(
      "times_to_rest",
      [](const AxisColumnsRef& states, const AxisColumnsRef& limits, const AxisTargets& targets) {
        const Unlocked unlocked;
        return times_to_rest({states, limits}, targets);
      },
      py::arg("states").noconvert(), py::arg("limits").noconvert(), py::arg("targets").noconvert());
  const auto def_step = [&](const char* name, auto step) {
    module.def(
        name,
        [step](const AxisColumnsRef& states, const AxisColumnsRef& limits,
               const AxisTargets& targets, double period) {
          const Unlocked unlocked;
          return step({states, limits}, targets, period);
        },
        py::arg("states").noconvert(), py::arg("limits").noconvert(),
        py::arg("targets").noconvert(), py::arg("period"));
  };
  def_step("step_each", &step_each);
  def_step("step_together", &step_together);
}

}  // namespace leadthrough
