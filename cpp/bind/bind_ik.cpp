#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "leadthrough/ik.hpp"
#include "leadthrough/so3.hpp"
#include "parts.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

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

}  // namespace

void bind_ik(py::module_& module) {
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

  module.def("solve_ik", &solve_one, py::arg("chain"), py::arg("position"),
             py::arg("orientation").noconvert(), py::arg("seed").noconvert(), py::arg("options"));
  module.def("solve_ik_batch", &solve, py::arg("chain"), py::arg("positions").noconvert(),
             py::arg("orientations").noconvert(), py::arg("seeds").noconvert(), py::arg("options"),
             py::arg("threads"));
}

}  // namespace leadthrough
