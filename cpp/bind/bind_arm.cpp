#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <stdexcept>

#include "leadthrough/so3.hpp"
#include "leadthrough/tracking.hpp"
#include "leadthrough/urdf.hpp"
#include "parts.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

// A document's text may be cut inside a character.
py::str to_text(const std::string& text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "replace"));
}

template <typename Value>
Value value_or_raise(std::variant<Value, urdf::Error>&& answer) {
  if (const auto* error = std::get_if<urdf::Error>(&answer)) {
    const py::object type = py::module_::import("leadthrough.errors").attr("InvalidRobot");
    PyErr_SetObject(type.ptr(), type(to_text(error->where), to_text(error->why)).ptr());
    throw py::error_already_set();
  }
  return std::get<Value>(std::move(answer));
}

urdf::Robot parse(const std::string& document) {
  auto answer = [&] {
    const py::gil_scoped_release release;
    return urdf::parse(document);
  }();
  return value_or_raise(std::move(answer));
}

std::vector<std::string> link_names(const urdf::Robot& robot) {
  std::vector<std::string> names;
  for (const urdf::Link& link : robot.links) names.push_back(link.name);
  return names;
}

std::vector<std::string> joint_names(const urdf::Robot& robot) {
  std::vector<std::string> names;
  for (const urdf::Joint& joint : robot.joints) names.push_back(joint.name);
  return names;
}

std::vector<std::string> leaf_names(const urdf::Robot& robot) {
  std::vector<bool> is_leaf(robot.links.size(), true);
  for (const urdf::Joint& joint : robot.joints)
    is_leaf[static_cast<std::size_t>(joint.parent)] = false;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < is_leaf.size(); ++i)
    if (is_leaf[i]) names.push_back(robot.links[i].name);
  return names;
}

// The Python layer says what is wrong; this keeps the kernels inside their arrays.
void require(bool sizes_agree) {
  if (!sizes_agree) throw std::invalid_argument("sizes of the arrays and of the chain differ");
}

bool fits(Eigen::Index rows, Eigen::Index orientations) {
  return orientations == rows || orientations == 0;
}

struct IkColumns {
  Rows q;
  Eigen::VectorXi status;
  Eigen::VectorXd position_errors, orientation_errors;
  Eigen::VectorXi iterations;
};

IkColumns columns(const std::vector<IkResult>& results, int joints) {
  const auto count = static_cast<Eigen::Index>(results.size());
  IkColumns table{Rows(count, joints), Eigen::VectorXi(count), Eigen::VectorXd(count),
                  Eigen::VectorXd(count), Eigen::VectorXi(count)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const IkResult& result = results[static_cast<std::size_t>(i)];
    table.q.row(i) = result.q;
    table.status[i] = static_cast<int>(result.status);
    table.position_errors[i] = result.position_error;
    table.orientation_errors[i] = result.orientation_error;
    table.iterations[i] = result.iterations;
  }
  return table;
}

// `orientation` has four numbers or none.
py::tuple solve_one(const Chain& chain, const Eigen::Vector3d& position,
                    const Eigen::Ref<const Eigen::VectorXd>& orientation,
                    const Eigen::Ref<const Eigen::VectorXd>& seed, const IkOptions& options) {
  require(seed.size() == chain.joints() && (orientation.size() == 4 || orientation.size() == 0));
  IkResult result;
  {
    const py::gil_scoped_release release;
    IkTarget target{position, std::nullopt};
    if (orientation.size() == 4) target.rotation = so3::to_matrix(orientation);
    result = solve_ik(chain, target, seed, options);
  }
  return py::make_tuple(result.q, static_cast<int>(result.status), result.position_error,
                        result.orientation_error, result.iterations);
}

py::tuple solve(const Chain& chain, const Eigen::Ref<const Rows3>& positions,
                const Eigen::Ref<const Rows4>& orientations, const Eigen::Ref<const Rows>& seeds,
                const IkOptions& options, int threads) {
  require(seeds.rows() == positions.rows() && seeds.cols() == chain.joints() &&
          fits(positions.rows(), orientations.rows()));
  IkColumns table;
  {
    const py::gil_scoped_release release;
    table = columns(solve_ik_batch(chain, positions, orientations, seeds, options, threads),
                    chain.joints());
  }
  return py::make_tuple(std::move(table.q), std::move(table.status),
                        std::move(table.position_errors), std::move(table.orientation_errors),
                        std::move(table.iterations));
}

py::tuple follow(const Chain& chain, const Eigen::Ref<const Rows3>& positions,
                 const Eigen::Ref<const Rows4>& orientations,
                 const Eigen::Ref<const Eigen::VectorXd>& start,
                 const Eigen::Ref<const Rows>& max_steps,
                 const Eigen::Ref<const Eigen::VectorXd>& midrange, const TrackOptions& options) {
  require(start.size() == chain.joints() && max_steps.cols() == chain.joints() &&
          max_steps.rows() == positions.rows() && midrange.size() == positions.rows() &&
          fits(positions.rows(), orientations.rows()));
  Track path;
  Eigen::VectorXi status;
  {
    const py::gil_scoped_release release;
    path = track(chain, positions, orientations, start, max_steps, midrange, options);
    status.resize(path.q.rows());
    std::transform(path.status.begin(), path.status.end(), status.data(),
                   [](IkStatus sample) { return static_cast<int>(sample); });
  }
  return py::make_tuple(std::move(path.q), std::move(status), std::move(path.position_errors),
                        std::move(path.orientation_errors));
}

}  // namespace

void bind_arm(py::module_& module) {
  py::class_<urdf::Robot>(module, "Robot")
      .def(py::init(&parse), py::arg("document"))
      .def_readonly("name", &urdf::Robot::name)
      .def_property_readonly("links", &link_names)
      .def_property_readonly("joints", &joint_names)
      .def_property_readonly("leaves", &leaf_names);

  py::class_<IkTolerance>(module, "IkTolerance")
      .def(py::init([](double position, double orientation) {
             return IkTolerance{position, orientation};
           }),
           py::arg("position"), py::arg("orientation"));

  py::class_<IkOptions>(module, "IkOptions")
      .def(py::init([](const IkTolerance& tolerance, double midrange, int max_iterations,
                       int max_restarts, std::uint64_t random_seed) {
             return IkOptions{tolerance, midrange, max_iterations, max_restarts, random_seed};
           }),
           py::arg("tolerance"), py::arg("midrange"), py::arg("max_iterations"),
           py::arg("max_restarts"), py::arg("random_seed"));

  py::class_<TrackOptions>(module, "TrackOptions")
      .def(py::init([](const IkTolerance& tolerance, int max_iterations) {
             return TrackOptions{tolerance, max_iterations};
           }),
           py::arg("tolerance"), py::arg("max_iterations"));

  py::class_<Chain>(module, "Chain")
      .def(py::init([](const urdf::Robot& robot, const std::string& base, const std::string& tip) {
             return value_or_raise(make_chain(robot, base, tip));
           }),
           py::arg("robot"), py::arg("base"), py::arg("tip"))
      .def_readonly("joint_names", &Chain::joint_names)
      .def_readonly("lower", &Chain::lower)
      .def_readonly("upper", &Chain::upper)
      .def_readonly("velocity", &Chain::velocity)
      .def_readonly("effort", &Chain::effort)
      .def_property_readonly("middle", &middle)
      .def(
          "with_bounds",
          [](const Chain& chain, const Eigen::Ref<const Eigen::VectorXd>& lower,
             const Eigen::Ref<const Eigen::VectorXd>& upper) {
            require(lower.size() == chain.joints() && upper.size() == chain.joints());
            Chain bounded = chain;
            bounded.lower = lower;
            bounded.upper = upper;
            return bounded;
          },
          py::arg("lower").noconvert(), py::arg("upper").noconvert())
      .def(
          "forward_kinematics",
          [](const Chain& chain, const Eigen::Ref<const Rows>& q) {
            require(q.cols() == chain.joints());
            Poses poses;
            {
              const py::gil_scoped_release release;
              poses = forward_kinematics_batch(chain, q);
            }
            return py::make_tuple(std::move(poses.positions), std::move(poses.orientations));
          },
          py::arg("q").noconvert())
      .def(
          "jacobian",
          [](const Chain& chain, const Eigen::Ref<const Eigen::VectorXd>& q) {
            require(q.size() == chain.joints());
            const py::gil_scoped_release release;
            return jacobian(chain, q);
          },
          py::arg("q").noconvert())
      .def("solve_ik", &solve_one, py::arg("position"), py::arg("orientation").noconvert(),
           py::arg("seed").noconvert(), py::arg("options"))
      .def("solve_ik_batch", &solve, py::arg("positions").noconvert(),
           py::arg("orientations").noconvert(), py::arg("seeds").noconvert(), py::arg("options"),
           py::arg("threads"))
      .def("track", &follow, py::arg("positions").noconvert(), py::arg("orientations").noconvert(),
           py::arg("start").noconvert(), py::arg("max_steps").noconvert(),
           py::arg("midrange").noconvert(), py::arg("options"));
}

}  // namespace leadthrough
