#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "leadthrough/time/jerk_filter.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using AxisColumnsRef = Eigen::Ref<const AxisColumns>;

void require_axes(const AxisColumnsRef& states, const AxisColumnsRef& limits,
                  const AxisTargets& targets) {
  require(states.rows() == 3 && limits.rows() == 6 && limits.cols() == states.cols() &&
          targets.size() == states.cols());
}

}  // namespace

void bind_jerk_filter(py::module_& module) {
  module.def(
      "resting_places",
      [](const AxisColumnsRef& states, const AxisColumnsRef& limits) {
        require(states.rows() == 3 && limits.rows() == 6 && limits.cols() == states.cols());
        const Unlocked unlocked;
        return resting_places({states, limits});
      },
      py::arg("states").noconvert(), py::arg("limits").noconvert());
  module.def(
      "times_to_rest",
      [](const AxisColumnsRef& states, const AxisColumnsRef& limits, const AxisTargets& targets) {
        require_axes(states, limits, targets);
        const Unlocked unlocked;
        return times_to_rest({states, limits}, targets);
      },
      py::arg("states").noconvert(), py::arg("limits").noconvert(), py::arg("targets").noconvert());
  const auto def_step = [&](const char* name, auto step) {
    module.def(
        name,
        [step](const AxisColumnsRef& states, const AxisColumnsRef& limits,
               const AxisTargets& targets, double period) {
          require_axes(states, limits, targets);
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
