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
  std::vector<Real> arrival =
      without_gil([&] { return march(grid, problem, {order, source_radius, stop}); });
  return moved_array(std::move(arrival), shape_of(speed));
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
    Update update{};
    {
      const Unlocked unlocked;
      const std::lock_guard<std::mutex> lock(mutex_);
      update = field_->update(region, speed.data());
    }
    return py::make_tuple(name(update.kind), update.invalidated);
  }

  py::array_t<Real> times() {
    std::vector<Real> times;
    {
      const Unlocked unlocked;
      const std::lock_guard<std::mutex> lock(mutex_);
      times = field_->times();
    }
    return moved_array(std::move(times), shape_);
  }

 private:
  static const char* name(UpdateKind kind) {
    switch (kind) {
      case UpdateKind::kNone:
        return "none";
      case UpdateKind::kRepair:
        return "repair";
      case UpdateKind::kFullMarch:
        break;
    }
    return "full_march";
  }

  std::vector<py::ssize_t> shape_;
  std::unique_ptr<ArrivalField<Real>> field_;
  std::mutex mutex_;
};

template <typename Real>
void bind_arrival_field(py::module_& module, const char* name) {
  using Bound = BoundArrivalField<Real>;
  py::class_<Bound>(module, name)
      .def(py::init<const CArray<Real>&, const std::vector<double>&, const CArray<Index>&>(),
           py::arg("speed").noconvert(), py::arg("spacing"), py::arg("cells").noconvert())
      .def("update", &Bound::update, py::arg("low"), py::arg("speed").noconvert())
      .def("times", [](Bound& field) { return field.times(); });
}

py::array_t<std::int32_t> label_sources(const CArray<double>& arrival,
                                        const std::vector<double>& spacing,
                                        const std::vector<Index>& cells) {
  const Grid grid = grid_of(arrival, spacing);
  for (const Index cell : cells) require(contains(grid, cell));
  std::vector<std::int32_t> labels =
      without_gil([&] { return nearest_sources(grid, arrival.data(), cells); });
  return moved_array(std::move(labels), shape_of(arrival));
}

py::array_t<double> transform(const CArray<bool>& mask, const std::vector<double>& spacing) {
  const Grid grid = grid_of(mask, spacing);
  std::vector<double> distance = without_gil(
      [&] { return distance_transform(grid, reinterpret_cast<const std::uint8_t*>(mask.data())); });
  return moved_array(std::move(distance), shape_of(mask));
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
                           const Eigen::Ref<const Rows>& positions, const Eigen::VectorXd& speeds,
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
py::tuple at_each(const Eigen::Ref<const Rows>& points, const Change& change) {
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

template <typename Real>
void bind_policy_of(py::class_<MarchingPolicy>& type) {
  type.def(
      py::init(&make_policy<Real>), py::arg("arrival").noconvert(), py::arg("spacing").noconvert(),
      py::arg("origin").noconvert(), py::arg("goal").noconvert(), py::arg("positions").noconvert(),
      py::arg("speeds").noconvert(), py::arg("mean_speed"), py::arg("slowing"), py::arg("barrier"));
}

// The functions that exist in both precisions.
template <typename Real>
void bind_marches(py::module_& module) {
  module.def("march", &march_one<Real>, py::arg("speed").noconvert(), py::arg("spacing"),
             py::arg("cells").noconvert(), py::arg("order"), py::arg("source_radius"),
             py::arg("stop"));
  module.def("march_batch", &march_many<Real>, py::arg("speeds"), py::arg("spacing"),
             py::arg("cells"), py::arg("order"), py::arg("source_radius"), py::arg("threads"));
}

template <typename Real>
void bind_descent(py::module_& module) {
  module.def("descend", &follow_down<Real>, py::arg("arrival").noconvert(), py::arg("spacing"),
             py::arg("start"), py::arg("goal"), py::arg("step"));
  module.def("directions", &find_directions<Real>, py::arg("arrival").noconvert(),
             py::arg("spacing"), py::arg("points").noconvert());
}

}  // namespace

void bind_field(py::module_& module) {
  bind_marches<float>(module);
  bind_marches<double>(module);
  bind_arrival_field<float>(module, "ArrivalFieldFloat32");
  bind_arrival_field<double>(module, "ArrivalFieldFloat64");
  module.def("nearest_sources", &label_sources, py::arg("arrival").noconvert(), py::arg("spacing"),
             py::arg("cells"));
  module.def("distance_transform", &transform, py::arg("mask").noconvert(), py::arg("spacing"));
  bind_descent<float>(module);
  bind_descent<double>(module);
  py::class_<MarchingPolicy> policy(module, "MarchingPolicy");
  bind_policy_of<float>(policy);
  bind_policy_of<double>(policy);
  policy
      .def(
          "velocities",
          [](const MarchingPolicy& own, const Eigen::Ref<const Rows>& points) {
            return at_each(points, [&](auto& point) { return own.velocity(point, point); });
          },
          py::arg("points").noconvert())
      .def(
          "moved",
          [](const MarchingPolicy& own, const Eigen::Ref<const Rows>& points, double span) {
            return at_each(points, [&](auto& point) { return own.step(span, point); });
          },
          py::arg("points").noconvert(), py::arg("span"));
}

}  // namespace leadthrough
