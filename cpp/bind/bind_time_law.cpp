#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "leadthrough/time/line_law.hpp"
#include "leadthrough/time/quintic_step.hpp"
#include "leadthrough/time/time_law.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using Vector = Eigen::Ref<const Eigen::VectorXd>;
using Table = Eigen::Ref<const Rows>;

// The path and its grid, which the caller may read to add bounds of its own.
class GriddedPath {
 public:
  GriddedPath(const Vector& breaks, const Table& coefficients, const Vector& scale,
              Eigen::Index points)
      : path_{breaks, coefficients} {
    const Unlocked unlocked;
    grid_ = make_path_grid(path_, scale, points);
  }

  const PathGrid& grid() const { return grid_; }

  py::tuple law(const Vector& velocity, const Vector& acceleration, const Vector& jerk,
                const Vector& fastest, const Table& gain, const Table& bend, const Table& lower,
                const Table& upper, double period, Eigen::Index parts, double start_speed,
                double end_speed, double longest, double most_delay) const {
    TimeLaw found;
    {
      const Unlocked unlocked;
      const RateLimits limits{velocity, acceleration, jerk};
      const PathBounds bounds{fastest, gain, bend, lower, upper};
      found = make_time_law(path_, grid_, limits, bounds,
                            {period, parts, start_speed, end_speed, longest, most_delay});
    }
    return py::make_tuple(static_cast<int>(found.status), found.failed_at, std::move(found.length),
                          std::move(found.speed), std::move(found.push), found.duration,
                          found.optimum, found.rounds, as_array(found.bottlenecks));
  }

  py::tuple states_along(const Vector& length, const Vector& speed, const Vector& push) const {
    MotionStates states =
        without_gil([&] { return leadthrough::states_along(path_, grid_, length, speed, push); });
    return py::make_tuple(std::move(states.positions), std::move(states.velocities),
                          std::move(states.accelerations));
  }

 private:
  PolynomialPath path_;
  PathGrid grid_;
};

py::tuple time_lines_(const Table& points, const Vector& velocity, const Vector& acceleration,
                      const Vector& jerk, double period, double longest) {
  LineMotions motions = without_gil(
      [&] { return time_lines(points, {velocity, acceleration, jerk}, period, longest); });
  Rows3 shares(static_cast<Eigen::Index>(motions.shares.size()), 3);
  for (Eigen::Index k = 0; k < shares.rows(); ++k) {
    const JointState& share = motions.shares[static_cast<std::size_t>(k)];
    shares.row(k) << share.position, share.velocity, share.acceleration;
  }
  return py::make_tuple(motions.failed_at, as_array(motions.steps), std::move(shares));
}

py::tuple step_extremes_(const Vector& times, const Table& positions, const Table& velocities,
                         const Table& accelerations) {
  StepExtremes found = step_extremes(times, positions, velocities, accelerations);
  return py::make_tuple(std::move(found.speed), std::move(found.acceleration));
}

py::tuple motion_peaks_(const Vector& times, const Table& positions, const Table& velocities,
                        const Table& accelerations) {
  MotionPeaks found =
      without_gil([&] { return motion_peaks(times, positions, velocities, accelerations); });
  return py::make_tuple(std::move(found.value), std::move(found.time), std::move(found.step));
}

}  // namespace

void bind_time_law(py::module_& module) {
  py::class_<GriddedPath>(module, "TimedPath")
      .def(py::init<const Vector&, const Table&, const Vector&, Eigen::Index>(),
           py::arg("breaks").noconvert(), py::arg("coefficients").noconvert(),
           py::arg("scale").noconvert(), py::arg("points"))
      .def_property_readonly("length", [](const GriddedPath& path) { return path.grid().length; })
      .def_property_readonly("parameter", [](const GriddedPath& path) { return path.grid().s; })
      .def_property_readonly("slope", [](const GriddedPath& path) { return path.grid().slope; })
      .def_property_readonly("positions",
                             [](const GriddedPath& path) { return path.grid().positions; })
      .def_property_readonly("first", [](const GriddedPath& path) { return path.grid().first; })
      .def_property_readonly("second", [](const GriddedPath& path) { return path.grid().second; })
      .def("law", &GriddedPath::law, py::arg("velocity").noconvert(),
           py::arg("acceleration").noconvert(), py::arg("jerk").noconvert(),
           py::arg("fastest").noconvert(), py::arg("gain").noconvert(), py::arg("bend").noconvert(),
           py::arg("lower").noconvert(), py::arg("upper").noconvert(), py::arg("period"),
           py::arg("parts"), py::arg("start_speed"), py::arg("end_speed"), py::arg("longest"),
           py::arg("most_delay"))
      .def("states_along", &GriddedPath::states_along, py::arg("length").noconvert(),
           py::arg("speed").noconvert(), py::arg("push").noconvert());
  module.def("time_lines", &time_lines_, py::arg("points").noconvert(),
             py::arg("velocity").noconvert(), py::arg("acceleration").noconvert(),
             py::arg("jerk").noconvert(), py::arg("period"), py::arg("longest"));
  for (const auto& [name, function] :
       {std::pair("step_extremes", &step_extremes_), std::pair("motion_peaks", &motion_peaks_)})
    module.def(name, function, py::arg("times").noconvert(), py::arg("positions").noconvert(),
               py::arg("velocities").noconvert(), py::arg("accelerations").noconvert());
}

}  // namespace leadthrough
