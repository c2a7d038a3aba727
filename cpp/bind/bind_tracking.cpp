#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "bind/parts.hpp"
#include "leadthrough/ik/tracking.hpp"
#include "leadthrough/time/slowing.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

py::tuple columns(Track&& path) {
  return py::make_tuple(std::move(path.q), std::move(path.position_errors),
                        std::move(path.orientation_errors));
}

py::tuple track_path(const Chain& chain, const Eigen::Ref<const Rows3>& positions,
                     const Eigen::Ref<const Rows4>& orientations,
                     const Eigen::Ref<const Eigen::VectorXd>& start,
                     const Eigen::Ref<const Rows>& postures,
                     const Eigen::Ref<const Eigen::VectorXd>& shares, const TrackOptions& options) {
  Track path = without_gil(
      [&] { return track(chain, positions, orientations, start, {postures, shares}, options); });
  return columns(std::move(path));
}

py::tuple pursue_path(const Chain& chain, const Eigen::Ref<const Eigen::VectorXd>& times,
                      const Eigen::Ref<const Rows3>& positions,
                      const Eigen::Ref<const Rows4>& orientations,
                      const Eigen::Ref<const Eigen::VectorXd>& start,
                      const Eigen::Ref<const Rows>& postures,
                      const Eigen::Ref<const Eigen::VectorXd>& shares,
                      const PursuitOptions& options) {
  Track path = without_gil([&] {
    return pursue(chain, {times, positions, orientations}, start, {postures, shares}, options);
  });
  return columns(std::move(path));
}

py::tuple slow(const Eigen::Ref<const Eigen::VectorXd>& times, const Eigen::Ref<const Rows>& q,
               const Eigen::Ref<const Eigen::VectorXd>& velocity,
               const Eigen::Ref<const Eigen::VectorXd>& acceleration) {
  Slowing slowing = without_gil([&] { return slow_down(times, q, velocity, acceleration); });
  return py::make_tuple(std::move(slowing.times), slowing.stuck);
}

}  // namespace

void bind_tracking(py::module_& module) {
  py::class_<TrackOptions>(module, "TrackOptions")
      .def(py::init([](const IkTolerance& tolerance, int max_iterations, double max_step,
                       const std::optional<IkAxes>& axes) {
             return TrackOptions{tolerance, max_iterations, max_step, axes};
           }),
           py::arg("tolerance"), py::arg("max_iterations"), py::arg("max_step"),
           py::arg("axes") = py::none());

  py::class_<PursuitOptions>(module, "PursuitOptions")
      .def(py::init([](const Eigen::VectorXd& velocity, const Eigen::VectorXd& acceleration,
                       double damping, const IkTolerance& deviation) {
             return PursuitOptions{velocity, acceleration, damping, deviation};
           }),
           py::arg("velocity"), py::arg("acceleration"), py::arg("damping"), py::arg("deviation"));

  module.def("track", &track_path, py::arg("chain"), py::arg("positions").noconvert(),
             py::arg("orientations").noconvert(), py::arg("start").noconvert(),
             py::arg("postures").noconvert(), py::arg("shares").noconvert(), py::arg("options"));
  module.def("pursue", &pursue_path, py::arg("chain"), py::arg("times").noconvert(),
             py::arg("positions").noconvert(), py::arg("orientations").noconvert(),
             py::arg("start").noconvert(), py::arg("postures").noconvert(),
             py::arg("shares").noconvert(), py::arg("options"));
  module.def("slow_down", &slow, py::arg("times").noconvert(), py::arg("q").noconvert(),
             py::arg("velocity").noconvert(), py::arg("acceleration").noconvert());
}

}  // namespace leadthrough
