#include <pybind11/eigen.h>

#include "bind/parts.hpp"
#include "learn/alignment.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using PointsRef = Eigen::Ref<const Points>;

// `compare` for two curves in one space, neither of them empty.
template <typename Result>
void def_comparison(py::module_& module, const char* name,
                    Result (*compare)(const PointsRef&, const PointsRef&)) {
  module.def(
      name,
      [compare](const PointsRef& a, const PointsRef& b) {
        require(a.rows() > 0 && b.rows() > 0 && a.cols() == b.cols());
        const py::gil_scoped_release release;
        return compare(a, b);
      },
      py::arg("a").noconvert(), py::arg("b").noconvert());
}

}  // namespace

void bind_alignment(py::module_& module) {
  def_comparison(module, "dtw_distance", &dtw_distance);
  def_comparison(module, "dtw_path", &dtw_path);
  def_comparison(module, "frechet_distance", &frechet_distance);
}

}  // namespace leadthrough
