#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include <array>
#include <memory>
#include <string>
#include <tuple>
#include <utility>

#include "bind/parts.hpp"
#include "leadthrough/simulation/error_loop.hpp"
#include "leadthrough/simulation/run.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using Eigen::Index;
using Eigen::VectorXd;
using simulation::Command;
using simulation::Drives;
using simulation::ErrorLoop;
using simulation::JointLaw;
using simulation::Moment;
using Values = CArray<double>;

JointLaw make_law(const Dynamics& dynamics, const Eigen::Vector3d& gravity, const VectorXd& rotors,
                  std::pair<double, double> of_motion, const VectorXd& springs,
                  const VectorXd& dampers, const std::string& model) {
  const simulation::Model adds = model == "motion"   ? simulation::Model::motion
                                 : model == "weight" ? simulation::Model::weight
                                                     : simulation::Model::none;
  return {dynamics, gravity, rotors, {of_motion.first, of_motion.second, springs, dampers}, adds};
}

VectorXd torques(JointLaw& law, const Command& target, const VectorXd& q, const VectorXd& qd) {
  require(target.rows() == 3 && target.cols() == law.joints());
  require(q.size() == law.joints() && qd.size() == law.joints());
  return law.torques({target.row(0), target.row(1), target.row(2), q, qd, 0.0});
}

// A law of the core, or a function of Python of the moment's values.
Drives::Law law_of(const py::object& law) {
  if (py::isinstance<JointLaw>(law)) {
    auto& own = law.cast<JointLaw&>();
    return [&own](const Moment& now, VectorXd& result) {
      require(own.joints() == now.q.size());
      result = own.torques(now);
    };
  }
  return [law](const Moment& now, VectorXd& result) {
    const auto torques =
        law(now.target_q, now.target_qd, now.qdd, now.q, now.qd, now.progress).cast<VectorXd>();
    require(torques.size() == now.q.size());
    result = torques;
  };
}

// The drives, and the arrays of the physics that they read and write.
struct DrivenArm {
  Values q, qd, control, ranges, force;
  Drives drives;

  DrivenArm(simulation::DriveValues values, const Command& start, std::vector<Index> joints,
            Values q_of_all, Values qd_of_all, Values asked, Values limits, Values given)
      : q(std::move(q_of_all)),
        qd(std::move(qd_of_all)),
        control(std::move(asked)),
        ranges(std::move(limits)),
        force(std::move(given)),
        drives(std::move(values),
               {q.data(), qd.data(), std::move(joints), control.mutable_data(),
                ranges.mutable_data(), force.data()},
               start) {}
};

// values: rows (5, joints) of encoders, rotors, the fed part of them, effort limits and dampers.
// state: positions and velocities of all joints, control, ranges and force of the arm's motors.
std::unique_ptr<DrivenArm> make_drives(const Rows& values, Index late, double period, int steps,
                                       double fastest, const Command& start,
                                       const std::vector<Index>& joints,
                                       const std::array<Values, 5>& state) {
  const auto& [q, qd, control, ranges, force] = state;
  const auto count = static_cast<py::ssize_t>(joints.size());
  for (const Index joint : joints) require(0 <= joint && joint < std::min(q.size(), qd.size()));
  require(control.size() == count && force.size() == count && ranges.size() == 2 * count);
  require(values.rows() == 5);
  return std::make_unique<DrivenArm>(
      simulation::DriveValues{values.row(0), values.row(1), values.row(2), values.row(3),
                              values.row(4), late, period, steps, fastest},
      start, joints, q, qd, control, ranges, force);
}

Index begin(DrivenArm& arm, const Command& command, double progress, const py::object& law) {
  require(command.rows() == 3 && command.cols() == arm.drives.joints());
  return arm.drives.begin(command, progress, law_of(law));
}

// The fields of a record, in their order.
auto run(DrivenArm& arm, const RowsRef& q, const RowsRef& qd, const RowsRef& qdd,
         const VectorRef& progress, const py::object& law, const std::function<bool()>& step,
         const std::function<void(Index)>& touched, Index periods_after_touch) {
  const Interruptible call{&signal_raises};  // not without the GIL: the physics is called in Python
  auto found = simulation::run(arm.drives, {q, qd, qdd, progress}, law_of(law),
                               {step, touched, periods_after_touch});
  return std::make_tuple(std::move(found.q), std::move(found.qd), std::move(found.qdd),
                         std::move(found.torques), std::move(found.work), std::move(found.given),
                         std::move(found.use), std::move(found.over), found.periods, found.runaway);
}

// values: rows (3, joints) of dampers, dry friction and the errors' first velocities.
ErrorLoop make_loop(const Rows& values, double period, int steps, Index late, Index every) {
  require(values.rows() == 3);
  return {{values.row(0), values.row(1), period, steps, late, every}, values.row(2).transpose()};
}

Rows advance(ErrorLoop& loop, const RowsRef& ease, const RowsRef& answer, const RowsRef& left,
             const RowsRef& q, const RowsRef& qd, const RowsRef& qdd) {
  const Unlocked unlocked;
  return loop.advance({ease, answer, left, q, qd, qdd});
}

}  // namespace

void bind_simulation(py::module_& module) {
  py::class_<JointLaw>(module, "JointLaw")
      .def(py::init(&make_law), "dynamics"_a, "gravity"_a, "rotors"_a, "of_motion"_a, "springs"_a,
           "dampers"_a, "model"_a)
      .def("torques", &torques, "target"_a, "q"_a, "qd"_a);
  py::class_<DrivenArm>(module, "Drives")
      .def(py::init(&make_drives), "values"_a, "late"_a, "period"_a, "steps"_a, "fastest"_a,
           "start"_a, "joints"_a, "state"_array)
      .def("begin", &begin, "command"_a, "progress"_a, "law"_a.none(false))
      .def(
          "act", [](DrivenArm& arm, int step) { arm.drives.act(step); }, "step"_a)
      .def("advance", [](DrivenArm& arm) { return arm.drives.advance(); })
      .def("end", [](DrivenArm& arm) { arm.drives.end(); })
      .def("run", &run, "q"_array, "qd"_array, "qdd"_array, "progress"_array, "law"_a.none(false),
           "step"_a.none(false), "touched"_a.none(false), "periods_after_touch"_a)
      .def_property_readonly("torques", [](const DrivenArm& arm) { return arm.drives.torques(); })
      .def_property_readonly("demanded", [](const DrivenArm& arm) { return arm.drives.demanded(); })
      .def_property_readonly("ticks", [](const DrivenArm& arm) { return arm.drives.ticks(); });
  py::class_<ErrorLoop>(module, "ErrorLoop")
      .def(py::init(&make_loop), "values"_a, "period"_a, "steps"_a, "late"_a, "every"_a)
      .def("advance", &advance, "ease"_array, "answer"_array, "left"_array, "q"_array, "qd"_array,
           "qdd"_array)
      .def_property_readonly("smooth", [](const ErrorLoop& loop) { return loop.smooth(); })
      .def_property_readonly("dry", [](const ErrorLoop& loop) { return loop.dry(); })
      .def_property_readonly("diverged", [](const ErrorLoop& loop) { return loop.diverged(); });
}

}  // namespace leadthrough
