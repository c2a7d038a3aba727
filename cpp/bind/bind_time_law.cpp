#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "time/kept_limits.hpp"
#include "time/line_law.hpp"
#include "time/sampled.hpp"
#include "time/time_law.hpp"

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
    require(breaks.size() > 1 && coefficients.rows() >= path_.pieces() &&
            coefficients.rows() % path_.pieces() == 0 && scale.size() == path_.joints() &&
            path_.joints() > 0 && points > 2);
    grid_ = make_path_grid(path_, scale, points);
  }

  const PathGrid& grid() const { return grid_; }

  py::tuple law(const Vector& velocity, const Vector& acceleration, const Vector& jerk,
                const Vector& fastest, const Table& gain, const Table& bend, const Table& lower,
                const Table& upper, double period, double start_speed, double end_speed,
                double longest, double most_delay) const {
    require(velocity.size() == path_.joints() && acceleration.size() == path_.joints() &&
            jerk.size() == path_.joints() && fastest.size() == grid_.points());
    for (const Table* table : {&gain, &bend, &lower, &upper})
      require(table->rows() == grid_.points() && table->cols() == gain.cols());
    TimeLaw found;
    {
      const py::gil_scoped_release release;
      const RateLimits limits{velocity, acceleration, jerk};
      const PathBounds bounds{fastest, gain, bend, lower, upper};
      found = make_time_law(path_, grid_, limits, bounds,
                            {period, start_speed, end_speed, longest, most_delay});
    }
    return py::make_tuple(static_cast<int>(found.status), found.failed_at, std::move(found.length),
                          found.duration, found.optimum, found.rounds, as_array(found.pinches));
  }

  Rows positions_at(const Vector& lengths) const {
    const py::gil_scoped_release release;
    return leadthrough::positions_at(path_, grid_, lengths);
  }

 private:
  PolynomialPath path_;
  PathGrid grid_;
};

py::tuple time_lines_(const Table& points, const Vector& velocity, const Vector& acceleration,
                      const Vector& jerk, double period, Eigen::Index parts, double longest) {
  const Eigen::Index joints = points.cols();
  require(velocity.size() == joints && acceleration.size() == joints && jerk.size() == joints &&
          parts > 0);
  LineMotions motions;
  {
    const py::gil_scoped_release release;
    motions = time_lines(points, {velocity, acceleration, jerk}, period, parts, longest);
  }
  return py::make_tuple(motions.failed_at, as_array(motions.steps), as_array(motions.shares));
}

py::tuple largest_use_(const Vector& times, const Table& positions, const Table& velocities,
                       const Table& accelerations, bool rests_at_start, bool rests_at_end,
                       const Vector& velocity, const Vector& acceleration, const Vector& jerk) {
  const Eigen::Index joints = positions.cols();
  require(times.size() > 0 && velocity.size() == joints && acceleration.size() == joints &&
          jerk.size() == joints);
  for (const Table* table : {&positions, &velocities, &accelerations})
    require(table->rows() == times.size() && table->cols() == joints);
  LimitUse use;
  {
    const py::gil_scoped_release release;
    use = largest_use({times, positions, velocities, accelerations, rests_at_start, rests_at_end},
                      {velocity, acceleration, jerk});
  }
  return py::make_tuple(use.order, use.sample, use.joint, use.ratio);
}

py::tuple central_differences_(const Vector& times, const Table& positions, const Table& beyond) {
  require(times.size() > 1 && positions.rows() == times.size() && beyond.rows() == 2 &&
          beyond.cols() == positions.cols());
  Derivatives found;
  {
    const py::gil_scoped_release release;
    found = central_differences(times, positions, beyond);
  }
  return py::make_tuple(std::move(found.velocities), std::move(found.accelerations));
}

py::array_t<Eigen::Index> stops_(const Table& positions, const Table& velocities) {
  require(positions.rows() == velocities.rows() && positions.cols() == velocities.cols());
  return as_array(stops(positions, velocities));
}

py::tuple extent_(const Table& rows) {
  require(rows.rows() > 0);
  const Extent found = extent_of(rows);
  return py::make_tuple(found.least, found.largest);
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
           py::arg("start_speed"), py::arg("end_speed"), py::arg("longest"), py::arg("most_delay"))
      .def("positions_at", &GriddedPath::positions_at, py::arg("lengths").noconvert());
  module.def("time_lines", &time_lines_, py::arg("points").noconvert(),
             py::arg("velocity").noconvert(), py::arg("acceleration").noconvert(),
             py::arg("jerk").noconvert(), py::arg("period"), py::arg("parts"), py::arg("longest"));
  module.def("central_differences", &central_differences_, py::arg("times").noconvert(),
             py::arg("positions").noconvert(), py::arg("beyond").noconvert());
  module.def("stops", &stops_, py::arg("positions").noconvert(), py::arg("velocities").noconvert());
  module.def("extent", &extent_, py::arg("rows").noconvert());
  module.def("largest_use", &largest_use_, py::arg("times").noconvert(),
             py::arg("positions").noconvert(), py::arg("velocities").noconvert(),
             py::arg("accelerations").noconvert(), py::arg("rests_at_start"),
             py::arg("rests_at_end"), py::arg("velocity").noconvert(),
             py::arg("acceleration").noconvert(), py::arg("jerk").noconvert());
}

}  // namespace leadthrough
