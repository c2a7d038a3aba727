#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "leadthrough/time/cubic_spline.hpp"
#include "leadthrough/time/curve_values.hpp"
#include "leadthrough/time/jerk_filter.hpp"
#include "leadthrough/time/line_law.hpp"
#include "leadthrough/time/quintic_step.hpp"
#include "leadthrough/time/slowing.hpp"
#include "leadthrough/time/spline_fit.hpp"
#include "leadthrough/time/time_law.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

py::tuple to_tuple(SplineFit&& fit) {
  return py::make_tuple(as_array(fit.breaks), std::move(fit.coefficients));
}

py::tuple fit_spline_(const VectorRef& parameters, const RowsRef& q, double tolerance,
                      bool corners) {
  return to_tuple(without_gil([&] { return fit_spline(parameters, q, tolerance, corners); }));
}

py::tuple smooth_spline_(const VectorRef& parameters, const RowsRef& q, double tolerance,
                         const VectorRef& lower, const VectorRef& upper) {
  return to_tuple(
      without_gil([&] { return smooth_spline(parameters, q, tolerance, {lower, upper}); }));
}

Rows spline_slopes_(const VectorRef& parameters, const RowsRef& q, bool at_rest) {
  const Unlocked unlocked;
  return spline_slopes(parameters, q, at_rest ? SplineEnds::kAtRest : SplineEnds::kSmooth);
}

py::array_t<Eigen::Index> rows_apart_(const RowsRef& q, double tolerance) {
  return as_array(without_gil([&] { return rows_apart(q, tolerance); }));
}

// The path and its grid, which the caller may read to add bounds of its own.
class GriddedPath {
 public:
  GriddedPath(const VectorRef& breaks, const RowsRef& coefficients, const VectorRef& scale,
              Eigen::Index points, const VectorRef& also)
      : path_{breaks, coefficients} {
    const Unlocked unlocked;
    grid_ = make_path_grid(path_, scale, points, {also.data(), also.data() + also.size()});
  }

  const PathGrid& grid() const { return grid_; }

  py::tuple law(const VectorRef& velocity, const VectorRef& acceleration, const VectorRef& jerk,
                const VectorRef& fastest, const RowsRef& gain, const RowsRef& bend,
                const RowsRef& lower, const RowsRef& upper, double period, Eigen::Index parts,
                double start_speed, double end_speed, double longest, double most_delay) const {
    TimeLaw found = without_gil([&] {
      return make_time_law(path_, grid_, {velocity, acceleration, jerk},
                           {fastest, gain, bend, lower, upper},
                           {period, parts, start_speed, end_speed, longest, most_delay});
    });
    return py::make_tuple(static_cast<int>(found.status), found.failed_at, std::move(found.length),
                          std::move(found.speed), std::move(found.push), found.duration,
                          found.optimum, found.rounds, as_array(found.bottlenecks));
  }

  py::tuple states_along(const VectorRef& length, const VectorRef& speed,
                         const VectorRef& push) const {
    MotionStates states =
        without_gil([&] { return leadthrough::states_along(path_, grid_, length, speed, push); });
    return py::make_tuple(std::move(states.positions), std::move(states.velocities),
                          std::move(states.accelerations));
  }

 private:
  PolynomialPath path_;
  PathGrid grid_;
};

py::tuple time_lines_(const RowsRef& points, const VectorRef& velocity,
                      const VectorRef& acceleration, const VectorRef& jerk, double period,
                      double longest) {
  LineMotions motions = without_gil(
      [&] { return time_lines(points, {velocity, acceleration, jerk}, period, longest); });
  Rows3 shares(static_cast<Eigen::Index>(motions.shares.size()), 3);
  for (Eigen::Index k = 0; k < shares.rows(); ++k) {
    const JointState& share = motions.shares[static_cast<std::size_t>(k)];
    shares.row(k) << share.position, share.velocity, share.acceleration;
  }
  return py::make_tuple(motions.failed_at, as_array(motions.steps), std::move(shares));
}

py::tuple step_extremes_(const VectorRef& times, const RowsRef& positions,
                         const RowsRef& velocities, const RowsRef& accelerations) {
  StepExtremes found = step_extremes(times, positions, velocities, accelerations);
  return py::make_tuple(std::move(found.speed), std::move(found.acceleration));
}

py::tuple motion_peaks_(const VectorRef& times, const RowsRef& positions, const RowsRef& velocities,
                        const RowsRef& accelerations) {
  MotionPeaks found =
      without_gil([&] { return motion_peaks(times, positions, velocities, accelerations); });
  return py::make_tuple(std::move(found.value), std::move(found.time), std::move(found.step));
}

py::tuple slow(const VectorRef& times, const RowsRef& q, const VectorRef& velocity,
               const VectorRef& acceleration) {
  Slowing slowing = without_gil([&] { return slow_down(times, q, velocity, acceleration); });
  return py::make_tuple(std::move(slowing.times), slowing.stuck);
}

}  // namespace

void bind_time(py::module_& module) {
  module.def("resting_places", &resting_places, "states"_array, "limits"_array, Unlocking());
  module.def("times_to_rest", &times_to_rest, "states"_array, "limits"_array, "targets"_array,
             Unlocking());
  for (const auto& [name, step] :
       {std::pair("step_each", &step_each), std::pair("step_together", &step_together)})
    module.def(name, step, "states"_array, "limits"_array, "targets"_array, "period"_a,
               Unlocking());

  module.def("fit_spline", &fit_spline_, "parameters"_array, "q"_array, "tolerance"_a, "corners"_a);
  module.def("smooth_spline", &smooth_spline_, "parameters"_array, "q"_array, "tolerance"_a,
             "lower"_array, "upper"_array);
  module.def("cubic_through", &cubic_through, "parameters"_array, "q"_array, Unlocking());
  module.def("spline_slopes", &spline_slopes_, "parameters"_array, "q"_array, "at_rest"_a);
  module.def("polynomial_values", &polynomial_values, "knots"_array, "coefficients"_array,
             "times"_array, "order"_a, Unlocking());
  module.def("bezier_values", &bezier_values, "points"_array, "fractions"_array, Unlocking());
  module.def("rows_apart", &rows_apart_, "q"_array, "tolerance"_a);

  py::class_<GriddedPath>(module, "TimedPath")
      .def(py::init<const VectorRef&, const RowsRef&, const VectorRef&, Eigen::Index,
                    const VectorRef&>(),
           "breaks"_array, "coefficients"_array, "scale"_array, "points"_a, "also"_array)
      .def_property_readonly("length", [](const GriddedPath& path) { return path.grid().length; })
      .def_property_readonly("parameter", [](const GriddedPath& path) { return path.grid().s; })
      .def_property_readonly("slope", [](const GriddedPath& path) { return path.grid().slope; })
      .def_property_readonly("positions",
                             [](const GriddedPath& path) { return path.grid().positions; })
      .def_property_readonly("first", [](const GriddedPath& path) { return path.grid().first; })
      .def_property_readonly("second", [](const GriddedPath& path) { return path.grid().second; })
      .def("law", &GriddedPath::law, "velocity"_array, "acceleration"_array, "jerk"_array,
           "fastest"_array, "gain"_array, "bend"_array, "lower"_array, "upper"_array, "period"_a,
           "parts"_a, "start_speed"_a, "end_speed"_a, "longest"_a, "most_delay"_a)
      .def("states_along", &GriddedPath::states_along, "length"_array, "speed"_array, "push"_array);
  module.def("slow_down", &slow, "times"_array, "q"_array, "velocity"_array, "acceleration"_array);
  module.def("time_lines", &time_lines_, "points"_array, "velocity"_array, "acceleration"_array,
             "jerk"_array, "period"_a, "longest"_a);
  for (const auto& [name, function] :
       {std::pair("step_extremes", &step_extremes_), std::pair("motion_peaks", &motion_peaks_)})
    module.def(name, function, "times"_array, "positions"_array, "velocities"_array,
               "accelerations"_array);
}

}  // namespace leadthrough
