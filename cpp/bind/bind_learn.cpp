#include <pybind11/eigen.h>

#include <algorithm>
#include <utility>

#include "bind/parts.hpp"
#include "leadthrough/learn/alignment.hpp"
#include "leadthrough/learn/arc_length.hpp"
#include "leadthrough/learn/basis_functions.hpp"
#include "leadthrough/learn/curves.hpp"
#include "leadthrough/learn/dense.hpp"
#include "leadthrough/learn/gaussian.hpp"
#include "leadthrough/learn/sample_truncated_gaussian.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

using Numbers = CArray<double>;
using NumbersIn = const Numbers&;
using VectorMap = Eigen::Map<const Eigen::VectorXd>;
using RowsMap = Eigen::Map<const Rows>;

// More via points are left to the checks in Python.
constexpr py::ssize_t kMaxVias = 100;

Polyline polyline_of(const CArray<double>& points) {
  require(points.ndim() == 2 && points.size() > 0);
  return {points.data(), static_cast<std::size_t>(points.shape(0)),
          static_cast<std::size_t>(points.shape(1))};
}

py::array_t<double> lengths_along(const CArray<double>& points) {
  const Polyline curve = polyline_of(points);
  return moved_array(without_gil([&] { return arc_lengths(curve); }, points.size() >= kLong));
}

// Rows at even lengths; None where the length of the curve is not finite.
py::object resampled(const CArray<double>& points, std::size_t count) {
  const Polyline curve = polyline_of(points);
  require(count >= 2);
  const bool is_long = std::max(points.size(), static_cast<py::ssize_t>(count)) >= kLong;
  const auto resample = [&] {
    const std::vector<double> lengths = arc_lengths(curve);
    return std::isfinite(lengths.back()) ? by_arc_length(curve, lengths, count)
                                         : std::vector<double>();
  };
  std::vector<double> rows = without_gil(resample, is_long);
  if (rows.empty()) return py::none();
  return moved_array(std::move(rows), {static_cast<py::ssize_t>(count), points.shape(1)});
}

// A row and a column for each of the curves (k, n, d).
py::array_t<double> between_curves(const CArray<double>& curves) {
  require(curves.ndim() == 3 && curves.size() > 0);
  const auto count = static_cast<std::size_t>(curves.shape(0));
  const Polyline first{curves.data(), static_cast<std::size_t>(curves.shape(1)),
                       static_cast<std::size_t>(curves.shape(2))};
  const bool is_long = curves.size() * curves.shape(0) >= kLong;
  return moved_array(without_gil([&] { return rms_apart(first, count); }, is_long),
                     {curves.shape(0), curves.shape(0)});
}

// Data of an array that the checks in Python accept unchanged; null for any other object.
const double* finite_rows(const py::handle& object, py::ssize_t rows, py::ssize_t columns) {
  if (!is_plain_array(object)) return nullptr;
  const auto array = py::reinterpret_borrow<Numbers>(object);
  if (array.ndim() != 2 || array.shape(0) != rows || array.shape(1) != columns) return nullptr;
  const double* values = array.data();
  return VectorMap(values, rows * columns).allFinite() ? values : nullptr;
}

// Phases of one time or of several; empty if Python must check them.
Eigen::VectorXd phases_of(const py::handle& time, double duration, bool periodic) {
  Eigen::VectorXd phases;
  if (PyFloat_Check(time.ptr())) {
    phases = Eigen::VectorXd::Constant(1, PyFloat_AS_DOUBLE(time.ptr()) / duration);
  } else {
    const bool several = is_plain_array(time);
    const auto size = several ? py::reinterpret_borrow<Numbers>(time).size() : 0;
    const double* times = size > 0 && size <= kMaxVias ? finite_vector(time, size) : nullptr;
    if (times) phases = VectorMap(times, size) / duration;
  }
  const auto inside = [&](double u) { return periodic ? std::isfinite(u) : u >= 0.0 && u <= 1.0; };
  return std::all_of(phases.begin(), phases.end(), inside) ? phases : Eigen::VectorXd();
}

// Mean and covariance of weights of basis functions after via points of all curves; nothing where
// an argument is not plainly right, or something was known before.
py::object condition_at(NumbersIn mean, NumbersIn covariance, NumbersIn centres, double sharpness,
                        bool periodic, NumbersIn scale, double duration, const py::object& time,
                        const py::object& position, const py::object& noise, double least) {
  const py::ssize_t curves = scale.size();
  const py::ssize_t size = mean.size();
  require(curves > 0 && centres.size() * curves == size && covariance.ndim() == 2 &&
          covariance.shape(0) == size && covariance.shape(1) == size);
  const Eigen::VectorXd phases = phases_of(time, duration, periodic);
  if (phases.size() == 0) return py::none();
  const double* values = PyFloat_Check(time.ptr()) ? finite_vector(position, curves)
                                                   : finite_rows(position, phases.size(), curves);
  const double* spread = finite_rows(noise, curves, curves);
  if (!values || !spread) return py::none();
  const RowsMap known(spread, curves, curves);
  if (!is_covariance(known)) return py::none();
  const Rows basis =
      normalised_basis(phases, VectorMap(centres.data(), centres.size()), sharpness, periodic, 0);
  Conditioned result = condition_weights(
      VectorMap(mean.data(), size), RowsMap(covariance.data(), size, size), basis,
      Columns::LinSpaced(curves, 0, curves - 1), RowsMap(values, phases.size(), curves), known,
      VectorMap(scale.data(), curves), least);
  if (result.certain) return py::none();
  return py::make_tuple(std::move(result.mean), std::move(result.covariance));
}

// Curves of weights over several bases, in arrays (motions, bases, n, curves) of at most so many
// motions, and whether they are certain to be finite. NumPy's memory comes in large pages: to get
// small ones takes longer than to fill them.
py::tuple curves(const BasisRows& basis, Eigen::Index functions, Eigen::Index bases,
                 Eigen::Index rows, const RowsRef& weights, py::ssize_t most, int threads) {
  require(functions > 0 && rows > 0 && weights.size() > 0 && weights.cols() % functions == 0 &&
          most > 0);
  const Eigen::Index width = weights.cols() / functions;
  py::list blocks;
  std::vector<double*> places;
  for (py::ssize_t first = 0; first < weights.rows(); first += most) {
    const py::ssize_t count = std::min(most, weights.rows() - first);
    Numbers block({count, bases, rows, width});
    for (py::ssize_t i = 0; i < count; ++i) places.push_back(block.mutable_data(i));
    blocks.append(std::move(block));
  }
  const bool certain =
      without_gil([&] { return fill_curves(basis, rows, weights, width, threads, places); });
  return py::make_tuple(std::move(blocks), certain);
}

// Curves over given rows of the bases, which lie below each other.
py::tuple curves_over(const RowsRef& basis, Eigen::Index bases, const RowsRef& weights,
                      py::ssize_t most, int threads) {
  require(bases > 0 && basis.rows() % bases == 0);
  const Eigen::Index rows = basis.rows() / bases;
  const auto part = [&](Eigen::Index first, Eigen::Index count) {
    Rows found(bases * count, basis.cols());
    for (Eigen::Index i = 0; i < bases; ++i)
      found.middleRows(i * count, count) = basis.middleRows(i * rows + first, count);
    return found;
  };
  return curves(part, basis.cols(), bases, rows, weights, most, threads);
}

// Curves over basis functions and their derivatives by time, of which there are as many as factors
// but one.
py::tuple curves_over_basis(const VectorRef& phases, const VectorRef& centres, double sharpness,
                            bool periodic, const VectorRef& factors, const RowsRef& weights,
                            py::ssize_t most, int threads) {
  require(factors.size() >= 1 && factors.size() <= 3);
  const auto part = [&](Eigen::Index first, Eigen::Index count) {
    Rows found = basis_and_derivatives(phases.segment(first, count), centres, sharpness, periodic,
                                       static_cast<int>(factors.size()) - 1);
    for (Eigen::Index i = 1; i < factors.size(); ++i)
      found.middleRows(i * count, count) *= factors[i];
    return found;
  };
  return curves(part, centres.size(), factors.size(), phases.size(), weights, most, threads);
}

}  // namespace

void bind_learn(py::module_& module) {
  for (const auto& [name, compare] :
       {std::pair("dtw_distance", &dtw_distance), std::pair("frechet_distance", &frechet_distance)})
    module.def(name, compare, "a"_array, "b"_array, "band"_a, Unlocking());
  module.def("dtw_path", &dtw_path, "a"_array, "b"_array, Unlocking());
  module.def("arc_lengths", &lengths_along, "points"_array);
  module.def("rms_apart", &between_curves, "curves"_array);
  module.def("by_arc_length", &resampled, "points"_array, "count"_a);

  module.def("sample_truncated_gaussian", &sample_truncated_gaussian, "walls"_array, "limits"_array,
             "start"_array, "velocities"_array, Unlocking());
  module.def(
      "condition_weights",
      [](const VectorRef& mean, const RowsRef& covariance, const RowsRef& basis,
         const Eigen::Ref<const Columns>& columns, const RowsRef& values, const RowsRef& noise,
         const VectorRef& scale, double least) {
        Conditioned result = without_gil([&] {
          return condition_weights(mean, covariance, basis, columns, values, noise, scale, least);
        });
        return py::make_tuple(result.certain, std::move(result.mean), std::move(result.covariance));
      },
      "mean"_array, "covariance"_array, "basis"_array, "columns"_array, "values"_array,
      "noise"_array, "scale"_array, "least"_a);
  module.def("condition_at", &condition_at, "mean"_array, "covariance"_array, "centres"_array,
             "sharpness"_a, "periodic"_a, "scale"_array, "duration"_a, "time"_a, "position"_a,
             "noise"_a, "least"_a);
  module.def("product", &product, "left"_array, "right"_array, Unlocking());
  module.def("solve_definite", &solve_definite, "matrix"_array, "right"_array, Unlocking());
  module.def("is_covariance", &is_covariance, "matrix"_array, Unlocking());
  module.def("normalised_basis", &normalised_basis, "phases"_array, "centres"_array, "sharpness"_a,
             "periodic"_a, "order"_a, Unlocking());
  module.def("curves_over", &curves_over, "basis"_array, "bases"_a, "weights"_array, "most"_a,
             "threads"_a);
  module.def("curves_over_basis", &curves_over_basis, "phases"_array, "centres"_array,
             "sharpness"_a, "periodic"_a, "factors"_array, "weights"_array, "most"_a, "threads"_a);
}

}  // namespace leadthrough
