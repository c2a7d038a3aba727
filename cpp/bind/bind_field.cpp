#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "bind/cells.hpp"
#include "leadthrough/field/arrival_field.hpp"
#include "leadthrough/field/descent.hpp"
#include "leadthrough/field/distance_transform.hpp"
#include "leadthrough/field/eikonal.hpp"
#include "leadthrough/field/nearest_source.hpp"
#include "leadthrough/field/policy.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

// Arrays have as many axes as there are numbers of spacing.
Grid grid_of(const py::array& cells, const std::vector<double>& spacing) {
  require(cells.size() > 0);
  return leadthrough::grid_of(std::vector<Index>(cells.shape(), cells.shape() + cells.ndim()),
                              spacing);
}

Coordinates with_leading_zero(const std::vector<double>& coordinates, std::size_t dimensions) {
  require(coordinates.size() == dimensions);
  Coordinates result{};
  std::copy_backward(coordinates.begin(), coordinates.end(), result.end());
  return result;
}

// A negative or non-finite speed would lead the march out of its queue.
template <typename Real>
void require_speeds(const CArray<Real>& speed) {
  const auto is_speed = [](Real each) { return std::isfinite(each) && each >= 0; };
  require(std::all_of(speed.data(), speed.data() + speed.size(), is_speed));
}

std::vector<py::ssize_t> shape_of(const py::array& array) {
  return {array.shape(), array.shape() + array.ndim()};
}

bool contains(const Grid& grid, Index cell) { return cell >= 0 && cell < grid.size(); }

std::vector<Source> sources_at(const Grid& grid, const CArray<Index>& cells) {
  require(cells.ndim() == 1);
  std::vector<Source> sources;
  for (py::ssize_t n = 0; n < cells.size(); ++n) {
    require(contains(grid, cells.at(n)));
    sources.push_back({cells.at(n)});
  }
  return sources;
}

void require_options(int order, double source_radius) {
  require((order == 1 || order == 2) && source_radius >= 0.0);
}

template <typename Real>
py::array_t<Real> march_one(const CArray<Real>& speed, const std::vector<double>& spacing,
                            const CArray<Index>& cells, int order, double source_radius,
                            Index stop) {
  const Grid grid = grid_of(speed, spacing);
  require_speeds(speed);
  require_options(order, source_radius);
  require(stop == kNoStop || contains(grid, stop));
  const MarchProblem<Real> problem{speed.data(), sources_at(grid, cells)};
  return moved_array(
      without_gil([&] { return march(grid, problem, {order, source_radius, stop}); }),
      shape_of(speed));
}

// One speed map a problem, all of one shape.
template <typename Real>
py::list march_many(const std::vector<CArray<Real>>& speeds, const std::vector<double>& spacing,
                    const std::vector<CArray<Index>>& cells, int order, double source_radius,
                    int threads) {
  const Grid grid = grid_of(speeds.at(0), spacing);
  std::vector<MarchProblem<Real>> problems;
  require(cells.size() == speeds.size());
  require_options(order, source_radius);
  for (std::size_t n = 0; n < speeds.size(); ++n) {
    require(shape_of(speeds[n]) == shape_of(speeds[0]));
    require_speeds(speeds[n]);
    problems.push_back({speeds[n].data(), sources_at(grid, cells[n])});
  }
  std::vector<std::vector<Real>> arrivals =
      without_gil([&] { return march_batch(grid, problems, {order, source_radius}, threads); });
  py::list result;
  for (std::vector<Real>& arrival : arrivals)
    result.append(moved_array(std::move(arrival), shape_of(speeds[0])));
  return result;
}

// The field with what numpy needs to know about it, for one thread at a time.
template <typename Real>
class BoundArrivalField {
 public:
  BoundArrivalField(const CArray<Real>& speed, const std::vector<double>& spacing,
                    const CArray<Index>& cells)
      : shape_(shape_of(speed)) {
    const Grid grid = grid_of(speed, spacing);
    require_speeds(speed);
    require(*std::max_element(speed.data(), speed.data() + speed.size()) > 0);
    const std::vector<Source> sources = sources_at(grid, cells);
    const Unlocked unlocked;
    field_ = make_arrival_field(grid, speed.data(), sources);
  }

  py::tuple update(const std::vector<Index>& low, const CArray<Real>& speed) {
    require(low.size() == shape_.size() && shape_of(speed).size() == shape_.size() &&
            speed.size() > 0);
    require_speeds(speed);
    Region region{{0, 0, 0}, {1, 1, 1}};
    const std::size_t lead = 3 - low.size();
    for (std::size_t axis = 0; axis < low.size(); ++axis) {
      region.low[lead + axis] = low[axis];
      region.shape[lead + axis] = speed.shape(static_cast<py::ssize_t>(axis));
      require(low[axis] >= 0 && low[axis] <= shape_[axis] - region.shape[lead + axis]);
    }
    const Update update = without_gil([&] {
      const std::lock_guard<std::mutex> lock(mutex_);
      return field_->update(region, speed.data());
    });
    constexpr std::array kinds{"none", "repair", "full_march"};  // in the order of UpdateKind
    return py::make_tuple(kinds[static_cast<std::size_t>(update.kind)], update.invalidated);
  }

  py::array_t<Real> times() {
    return moved_array(without_gil([&] {
                         const std::lock_guard<std::mutex> lock(mutex_);
                         return field_->times();
                       }),
                       shape_);
  }

 private:
  std::vector<py::ssize_t> shape_;
  std::unique_ptr<ArrivalField<Real>> field_;
  std::mutex mutex_;
};

py::array_t<std::int32_t> label_sources(const CArray<double>& arrival,
                                        const std::vector<double>& spacing,
                                        const std::vector<Index>& cells) {
  const Grid grid = grid_of(arrival, spacing);
  for (const Index cell : cells) require(contains(grid, cell));
  return moved_array(without_gil([&] { return nearest_sources(grid, arrival.data(), cells); }),
                     shape_of(arrival));
}

py::array_t<double> transform(const CArray<bool>& mask, const std::vector<double>& spacing) {
  const Grid grid = grid_of(mask, spacing);
  const auto* walls = reinterpret_cast<const std::uint8_t*>(mask.data());
  return moved_array(without_gil([&] { return distance_transform(grid, walls); }), shape_of(mask));
}

template <typename Real>
py::tuple follow_down(const CArray<Real>& arrival, const std::vector<double>& spacing,
                      const std::vector<double>& start, const std::vector<double>& goal,
                      double step) {
  const Grid grid = grid_of(arrival, spacing);
  const std::size_t dimensions = spacing.size();
  const Coordinates from = with_leading_zero(start, dimensions);
  const Coordinates to_cell = with_leading_zero(goal, dimensions);
  Descent descent = without_gil([&] { return descend(grid, arrival.data(), from, to_cell, step); });
  py::array_t<double> path({descent.path.size(), dimensions});
  double* to = path.mutable_data();
  for (const Coordinates& p : descent.path)
    to = std::copy(p.end() - static_cast<std::ptrdiff_t>(dimensions), p.end(), to);
  return py::make_tuple(name(descent.status), path);
}

// Directions (n, d) and, where there is none, the first such point's number and why.
template <typename Real>
py::tuple find_directions(const CArray<Real>& arrival, const std::vector<double>& spacing,
                          const CArray<double>& points) {
  const Grid grid = grid_of(arrival, spacing);
  const std::size_t dimensions = spacing.size();
  require(points.ndim() == 2 && points.shape(1) == static_cast<py::ssize_t>(dimensions));
  const auto count = static_cast<std::size_t>(points.shape(0));
  py::array_t<double> directions({count, dimensions});
  const double* from = points.data();
  double* to = directions.mutable_data();
  DescentStatus status = DescentStatus::kOk;
  std::size_t n = 0;
  {
    const Unlocked unlocked;
    for (; n < count; ++n, from += dimensions) {
      check_interrupt(n);
      Coordinates p{};
      std::copy_backward(from, from + dimensions, p.end());
      const Direction found = direction(grid, arrival.data(), p);
      status = found.status;
      if (status != DescentStatus::kOk) break;
      to = std::copy(found.unit.end() - static_cast<std::ptrdiff_t>(dimensions), found.unit.end(),
                     to);
    }
  }
  return py::make_tuple(name(status), n, directions);
}

using Disc = std::tuple<Eigen::VectorXd, Eigen::VectorXd, double, double>;

template <typename Real>
MarchingPolicy make_policy(const CArray<Real>& arrival, const Eigen::VectorXd& spacing,
                           const Eigen::VectorXd& origin, const Eigen::VectorXd& goal,
                           const RowsRef& positions, const Eigen::VectorXd& speeds,
                           double mean_speed, double slowing, const std::optional<Disc>& barrier) {
  Eigen::VectorXd shape(arrival.ndim());
  for (py::ssize_t i = 0; i < arrival.ndim(); ++i) shape[i] = static_cast<double>(arrival.shape(i));
  std::optional<StartBarrier> disc;
  if (barrier) {
    const auto& [middle, normal, width, thickness] = *barrier;
    disc = {middle, normal, width, thickness};
  }
  return MarchingPolicy({shape, spacing, origin, arrival.data(),
                         std::make_shared<CArray<Real>>(arrival), goal, positions, speeds,
                         mean_speed, slowing, disc});
}

// How many of the points (n, d) have a result, and the results; the next row is then the point
// that has no velocity.
template <typename Change>
py::tuple at_each(const RowsRef& points, const Change& change) {
  Rows rows = points;
  Eigen::Index n = 0;
  {
    const Unlocked unlocked;
    for (; n < rows.rows(); ++n) {
      check_interrupt(n);
      Eigen::Map<Eigen::VectorXd> point(rows.row(n).data(), rows.cols());
      if (change(point) != DescentStatus::kOk) break;
    }
  }
  return py::make_tuple(n, std::move(rows));
}

// The bindings that exist in both precisions.
template <typename Real>
void bind_precision(py::module_& module, const char* name_of_field,
                    py::class_<MarchingPolicy>& policy) {
  using Field = BoundArrivalField<Real>;
  py::class_<Field>(module, name_of_field)
      .def(py::init<const CArray<Real>&, const std::vector<double>&, const CArray<Index>&>(),
           "speed"_array, "spacing"_a, "cells"_array)
      .def("update", &Field::update, "low"_a, "speed"_array)
      .def("times", [](Field& field) { return field.times(); });
  module.def("march", &march_one<Real>, "speed"_array, "spacing"_a, "cells"_array, "order"_a,
             "source_radius"_a, "stop"_a);
  module.def("march_batch", &march_many<Real>, "speeds"_a, "spacing"_a, "cells"_a, "order"_a,
             "source_radius"_a, "threads"_a);
  module.def("descend", &follow_down<Real>, "arrival"_array, "spacing"_a, "start"_a, "goal"_a,
             "step"_a);
  module.def("directions", &find_directions<Real>, "arrival"_array, "spacing"_a, "points"_array);
  policy.def(py::init(&make_policy<Real>), "arrival"_array, "spacing"_array, "origin"_array,
             "goal"_array, "positions"_array, "speeds"_array, "mean_speed"_a, "slowing"_a,
             "barrier"_a);
}

}  // namespace

void bind_field(py::module_& module) {
  py::class_<MarchingPolicy> policy(module, "MarchingPolicy");
  bind_precision<float>(module, "ArrivalFieldFloat32", policy);
  bind_precision<double>(module, "ArrivalFieldFloat64", policy);
  module.def("nearest_sources", &label_sources, "arrival"_array, "spacing"_a, "cells"_a);
  module.def("distance_transform", &transform, "mask"_array, "spacing"_a);
  policy
      .def(
          "velocities",
          [](const MarchingPolicy& own, const RowsRef& points) {
            return at_each(points, [&](auto& point) { return own.velocity(point, point); });
          },
          "points"_array)
      .def(
          "moved",
          [](const MarchingPolicy& own, const RowsRef& points, double span) {
            return at_each(points, [&](auto& point) { return own.step(span, point); });
          },
          "points"_array, "span"_a);
}

}  // namespace leadthrough
