#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>

#include "bind/parts.hpp"
#include "leadthrough/dmp/avoidance.hpp"
#include "leadthrough/dmp/orientation_curve.hpp"
#include "leadthrough/dmp/primitive.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using dmp::Canonical;
using dmp::Course;
using dmp::Curve;
using dmp::Forces;
using dmp::Path;
using dmp::Representation;
using dmp::RotationState;
using dmp::Vector;

// State of a running motion. Poses hold three coordinates of their rotation behind the position.
struct PointState {
  std::shared_ptr<Course> course;
  dmp::State state;
  double duration;

  Eigen::Index channels() const { return state.value.size(); }
};

struct PoseState : PointState {
  std::shared_ptr<Curve> curve;
  std::shared_ptr<Path> offset;

  so3::Quaternion orientation() const {
    return dmp::orientation_at(*curve, *offset, state.phase, state.value.tail<3>());
  }

  // An array that owns its numbers is made quicker than one that refers to a matrix.
  py::array_t<double> pose() const {
    py::array_t<double> row(7);
    Eigen::Map<Eigen::Matrix<double, 7, 1>>(row.mutable_data()) << state.value.head<3>(),
        orientation();
    return row;
  }

  RotationState rotation() const {
    return dmp::rotation_at(*curve, *offset, state.phase, state.value.tail<3>(),
                            state.slope.tail<3>());
  }
};

constexpr double kMaxPeriodsPerStep = 1e3;

double span_of(double dt, double duration) {
  const double span = dt / duration;
  require(span >= 0.0 && span <= kMaxPeriodsPerStep);
  return span;
}

Canonical canonical_of(bool rhythmic) {
  return rhythmic ? Canonical::kRhythmic : Canonical::kDiscrete;
}

std::shared_ptr<Forces> make_forces(const RowsRef& nodes, const VectorRef& fade, double rate,
                                    bool rhythmic) {
  require(nodes.rows() >= 2 && fade.size() == nodes.rows() && rate > 0.0);
  return std::make_shared<Forces>(Forces{nodes, fade, rate, canonical_of(rhythmic)});
}

Path path_of(const VectorRef& breaks, const RowsRef& coefficients) {
  require(breaks.size() >= 2 && coefficients.rows() == 6 * (breaks.size() - 1));
  return {breaks, coefficients};
}

std::shared_ptr<Path> make_path(const VectorRef& breaks, const RowsRef& coefficients) {
  return std::make_shared<Path>(path_of(breaks, coefficients));
}

Vector first_of(const Path& path) { return path.coefficients.row(0); }

// A value of a path of rotation vectors; an empty one is at 0.
Vector offset_at(const Path& path, Vector (*value)(const Path&)) {
  return path.empty() ? Vector(Vector::Zero(3)) : value(path);
}

Path corrected(const Path& path, double phase, double until, const VectorRef& value,
               const VectorRef& slope, const VectorRef& shift) {
  return dmp::superposed(path, {phase, until, value, slope, shift});
}

std::shared_ptr<Course> make_course(const VectorRef& breaks, const RowsRef& coefficients,
                                    const VectorRef& gain, const VectorRef& drive) {
  const Eigen::Index channels = coefficients.cols();
  require(gain.size() == channels && drive.size() == channels);
  return std::make_shared<Course>(Course{path_of(breaks, coefficients), gain, drive});
}

// The course whose reference is a path with its start and goal shifted by the progress.
Course shifted_course(const VectorRef& breaks, const RowsRef& coefficients, const RowsRef& progress,
                      const VectorRef& start, const VectorRef& goal) {
  const Eigen::Index channels = coefficients.cols();
  return {dmp::shifted(path_of(breaks, coefficients), progress, start, goal),
          Vector::Ones(channels), Vector::Zero(channels)};
}

Course corrected_course(const Course& course, double phase, double until, const VectorRef& value,
                        const VectorRef& slope, const VectorRef& shift) {
  return {corrected(course.reference, phase, until, value, slope, shift), course.gain,
          course.drive};
}

std::shared_ptr<Curve> make_curve(const Rows4Ref& controls, const Rows3Ref& steps,
                                  const VectorRef& speeds, const VectorRef& covered, bool zyz,
                                  bool rhythmic) {
  require(controls.rows() >= 4 && steps.rows() == controls.rows() - 1);
  require(speeds.size() >= 2 && covered.size() == speeds.size());
  return std::make_shared<Curve>(Curve{controls, steps, speeds, covered,
                                       zyz ? Representation::kZyz : Representation::kRotationVector,
                                       canonical_of(rhythmic)});
}

PointState make_point_state(std::shared_ptr<Course> course, const VectorRef& value,
                            const VectorRef& slope, double phase, double duration) {
  require(value.size() == course->reference.coefficients.cols() && slope.size() == value.size() &&
          phase >= 0.0 && phase <= dmp::kMaxPhase && duration > 0.0);
  return {std::move(course), {value, slope, phase}, duration};
}

PoseState make_pose_state(std::shared_ptr<Course> course, const VectorRef& value,
                          const VectorRef& slope, double phase, double duration,
                          std::shared_ptr<Curve> curve, std::shared_ptr<Path> offset) {
  require(value.size() == 6 && dmp::is_offset(*offset));
  return {make_point_state(std::move(course), value, slope, phase, duration), std::move(curve),
          std::move(offset)};
}

py::tuple rollout(const Forces& forces, const Course& course, const VectorRef& value,
                  const VectorRef& slope, const VectorRef& phases) {
  require(phases.size() > 0);
  dmp::Rollout result =
      without_gil([&] { return dmp::rollout(forces, course, {value, slope, phases[0]}, phases); });
  return py::make_tuple(std::move(result.values), std::move(result.slopes));
}

// Accelerations per s^2 in what the channels obey: an angular one, in the base frame, becomes one
// of the coordinates.
Vector push_of(const PointState& state, const VectorRef& acceleration) {
  return state.duration * state.duration * acceleration;
}

Vector push_of(const PoseState& state, const VectorRef& acceleration) {
  Vector push = state.duration * state.duration * acceleration;
  if (push.size() == 6 && !push.tail<3>().isZero(0.0))
    push.tail<3>() =
        dmp::coordinate_push(*state.curve, *state.offset, state.state.phase,
                             state.state.value.tail<3>(), so3::Vector3(push.tail<3>()));
  return push;
}

template <typename State>
State step(const State& before, const Forces& forces, double dt, const VectorRef& acceleration) {
  require(forces.nodes.cols() == before.channels() && acceleration.size() == before.channels());
  State after = before;
  const Vector push = push_of(before, acceleration);
  dmp::advance(forces, *before.course, push, span_of(dt, before.duration), after.state);
  return after;
}

template <typename State>
State coast(const State& before, const Forces& forces, double dt) {
  return step(before, forces, dt, Vector::Zero(before.channels()));
}

// Nothing where dt is not in (0, duration]: such steps are rare, and to be checked first.
template <typename State>
std::optional<State> tick(const State& before, const Forces& forces, double dt) {
  if (!(dt > 0.0 && dt <= before.duration)) return std::nullopt;
  require(forces.nodes.cols() == before.channels());
  std::optional<State> after = before;
  dmp::advance(forces, *before.course, Vector::Zero(before.channels()), dt / before.duration,
               after->state);
  return after;
}

std::shared_ptr<dmp::AvoidanceScene> make_avoidance_scene(const std::vector<Shape>& shapes,
                                                          const VectorRef& margins, double reach,
                                                          const VectorRef& lower,
                                                          const VectorRef& upper) {
  require(margins.size() == static_cast<Eigen::Index>(shapes.size()) &&
          lower.size() == upper.size());
  auto result = std::make_shared<dmp::AvoidanceScene>();
  result->reach = reach;
  result->lower = lower;
  result->upper = upper;
  for (std::size_t i = 0; i < shapes.size(); ++i)
    result->obstacles.push_back({shapes[i], margins[static_cast<Eigen::Index>(i)]});
  return result;
}

bool fits(const dmp::AvoidanceScene& scene, Eigen::Index channels) {
  return scene.lower.size() == 0 || scene.lower.size() == channels;
}

py::tuple rollout_around(const Forces& forces, const Course& course,
                         const dmp::AvoidanceScene& scene, const VectorRef& value,
                         const VectorRef& slope, const VectorRef& phases) {
  require(phases.size() > 0);
  dmp::Passage result = without_gil([&] {
    return dmp::rollout_around(forces, course, scene, {value, slope, phases[0]}, phases);
  });
  return py::make_tuple(std::move(result.rollout.values), std::move(result.rollout.slopes),
                        result.last_push);
}

template <typename State>
State step_around(const State& before, const Forces& forces, double dt,
                  const VectorRef& acceleration, const dmp::AvoidanceScene& scene) {
  require(forces.nodes.cols() == before.channels() && acceleration.size() == before.channels() &&
          fits(scene, before.channels()));
  State after = before;
  const Vector push = push_of(before, acceleration);
  dmp::advance_around(forces, *before.course, scene, push, span_of(dt, before.duration),
                      after.state);
  return after;
}

so3::Quaternions orientations(const Curve& curve, const Path& offset, const VectorRef& phases,
                              const RowsRef& values) {
  const Unlocked unlocked;
  return dmp::orientations_at(curve, offset, phases, values);
}

// Positions and orientations of the motion that a state begins.
py::tuple poses(const Forces& forces, const PoseState& state, const VectorRef& phases) {
  dmp::Poses result = without_gil([&] {
    return dmp::poses_along(forces, *state.course, *state.curve, *state.offset, state.state,
                            phases);
  });
  return py::make_tuple(std::move(result.positions), std::move(result.orientations));
}

// The highest linear and angular speed of the motion that a state begins.
py::tuple peak_speeds(const Forces& forces, const PoseState& state, const VectorRef& phases) {
  require(phases.size() > 0);
  const dmp::Peaks peaks = without_gil([&] {
    const dmp::State first{state.state.value, state.state.slope, phases[0]};
    const dmp::Rollout motion = dmp::rollout(forces, *state.course, first, phases);
    return dmp::peak_speeds(*state.curve, *state.offset, phases, motion);
  });
  return py::make_tuple(peaks.linear, peaks.angular);
}

// Value and slope of the coordinates of an orientation and its angular velocity per phase.
py::tuple coordinates(const Curve& curve, const Path& offset, double phase,
                      const so3::Quaternion& orientation, const so3::Vector3& velocity,
                      const so3::Vector3& near) {
  require(dmp::is_offset(offset));
  const dmp::Coordinates result =
      dmp::coordinates_of(curve, offset, phase, {orientation, velocity}, near);
  return py::make_tuple(result.value, result.slope);
}

// Pickles and copies are made anew of the arguments.
template <typename Class, typename Arguments>
void bind_reduce(Class& type, const Arguments& arguments) {
  type.def("__reduce__", [arguments](const py::object& self) {
    const auto& object = self.cast<const typename Class::type&>();
    return py::make_tuple(py::type::of(self), arguments(object));
  });
}

template <typename State>
void bind_common(py::class_<State>& type) {
  type.def_property_readonly("phase", [](const State& s) { return s.state.phase; })
      .def_property_readonly("duration", [](const State& s) { return s.duration; })
      .def_property_readonly("course", [](const State& s) { return s.course; })
      .def_property_readonly("value", [](const State& s) { return s.state.value; })
      .def_property_readonly("slope", [](const State& s) { return s.state.slope; })
      .def("coast", &coast<State>, "forces"_a, "dt"_a)
      .def("tick", &tick<State>, "forces"_a, "dt"_a)
      .def("pushed", &step<State>, "forces"_a, "dt"_a, "acceleration"_array)
      .def("led_around", &step_around<State>, "forces"_a, "dt"_a, "acceleration"_array, "scene"_a);
}

}  // namespace

void bind_dmp(py::module_& module) {
  py::class_<Forces, std::shared_ptr<Forces>>(module, "DmpForces")
      .def(py::init(&make_forces), "nodes"_array, "fade"_array, "rate"_a, "rhythmic"_a)
      .def_readonly("nodes", &Forces::nodes)
      .def_readonly("fade", &Forces::fade);
  py::class_<Path, std::shared_ptr<Path>> path(module, "DmpPath");
  path.def(py::init<>())
      .def(py::init(&make_path), "breaks"_array, "coefficients"_array)
      .def_property_readonly("start", [](const Path& p) { return offset_at(p, &first_of); })
      .def_property_readonly("end", [](const Path& p) { return offset_at(p, &dmp::end_of); })
      .def("superposed", &corrected, "phase"_a, "until"_a, "value"_array, "slope"_array,
           "shift"_array);
  bind_reduce(path, [](const Path& p) -> py::tuple {
    return p.empty() ? py::tuple() : py::make_tuple(p.breaks, p.coefficients);
  });
  py::class_<Course, std::shared_ptr<Course>> course(module, "DmpCourse");
  course
      .def(py::init(&make_course), "breaks"_array, "coefficients"_array, "gain"_array,
           "drive"_array)
      .def_property_readonly("breaks", [](const Course& c) { return c.reference.breaks; })
      .def_property_readonly("coefficients",
                             [](const Course& c) { return c.reference.coefficients; })
      .def("superposed", &corrected_course, "phase"_a, "until"_a, "value"_array, "slope"_array,
           "shift"_array)
      .def_readonly("gain", &Course::gain)
      .def_readonly("drive", &Course::drive);
  bind_reduce(course, [](const Course& c) {
    return py::make_tuple(c.reference.breaks, c.reference.coefficients, c.gain, c.drive);
  });
  py::class_<Curve, std::shared_ptr<Curve>> curve(module, "DmpCurve");
  curve
      .def(py::init(&make_curve), "controls"_array, "steps"_array, "speeds"_array, "covered"_array,
           "zyz"_a, "rhythmic"_a)
      .def_readonly("steps", &Curve::steps)
      .def_readonly("covered", &Curve::covered);
  bind_reduce(curve, [](const Curve& c) {
    return py::make_tuple(c.controls, c.steps, c.speeds, c.covered,
                          c.representation == Representation::kZyz,
                          c.canonical == canonical_of(true));
  });

  py::class_<dmp::AvoidanceScene, std::shared_ptr<dmp::AvoidanceScene>>(module, "AvoidanceScene")
      .def(py::init(&make_avoidance_scene), "shapes"_a, "margins"_array, "reach"_a, "lower"_array,
           "upper"_array);

  py::class_<PointState> point(module, "PointState");
  point
      .def(py::init(&make_point_state), "course"_a.none(false), "value"_array, "slope"_array,
           "phase"_a, "duration"_a)
      .def_property_readonly("position", [](const PointState& s) { return s.state.value; })
      .def_property_readonly(
          "velocity", [](const PointState& s) { return Vector(s.state.slope / s.duration); });
  bind_common(point);
  bind_reduce(point, [](const PointState& s) {
    return py::make_tuple(s.course, s.state.value, s.state.slope, s.state.phase, s.duration);
  });

  py::class_<PoseState> pose(module, "PoseState");
  pose.def(py::init(&make_pose_state), "course"_a.none(false), "value"_array, "slope"_array,
           "phase"_a, "duration"_a, "curve"_a.none(false), "offset"_a.none(false))
      .def_property_readonly(
          "position", [](const PoseState& s) { return so3::Vector3(s.state.value.head<3>()); })
      .def_property_readonly(
          "velocity",
          [](const PoseState& s) { return so3::Vector3(s.state.slope.head<3>() / s.duration); })
      .def_property_readonly("curve", [](const PoseState& s) { return s.curve; })
      .def_property_readonly("offset", [](const PoseState& s) { return s.offset; })
      .def_property_readonly("orientation", [](const PoseState& s) { return s.orientation(); })
      .def_property_readonly("pose", [](const PoseState& s) { return s.pose(); })
      .def_property_readonly("angular_velocity", [](const PoseState& s) {
        return so3::Vector3(s.rotation().velocity / s.duration);
      });
  bind_common(pose);
  bind_reduce(pose, [](const PoseState& s) {
    return py::make_tuple(s.course, s.state.value, s.state.slope, s.state.phase, s.duration,
                          s.curve, s.offset);
  });

  module.def("dmp_rollout", &rollout, "forces"_a, "course"_a, "value"_array, "slope"_array,
             "phases"_array);
  module.def("dmp_rollout_around", &rollout_around, "forces"_a, "course"_a, "scene"_a,
             "value"_array, "slope"_array, "phases"_array);
  module.def("dmp_shifted_course", &shifted_course, "breaks"_array, "coefficients"_array,
             "progress"_array, "start"_array, "goal"_array);
  module.def("dmp_offset", &dmp::offset_between, "wanted"_array, "demonstrated"_array,
             "near"_array);
  module.def("dmp_orientations", &orientations, "curve"_a, "offset"_a, "phases"_array,
             "values"_array);
  module.def("dmp_poses", &poses, "forces"_a, "state"_a, "phases"_array);
  module.def("dmp_peak_speeds", &peak_speeds, "forces"_a, "state"_a, "phases"_array);
  module.def("dmp_coordinates", &coordinates, "curve"_a, "offset"_a, "phase"_a, "orientation"_array,
             "velocity"_array, "near"_array);
}

}  // namespace leadthrough
