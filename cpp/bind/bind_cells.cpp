#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "bind/cells.hpp"
#include "field/cell_set.hpp"
#include "field/descent.hpp"
#include "field/sparse_distance.hpp"
#include "field/sparse_march.hpp"
#include "field/waves.hpp"

namespace py = pybind11;

namespace leadthrough {

namespace {

// Cells of a grid with what is computed on them.
class BoundCells {
 public:
  BoundCells(const std::vector<Index>& shape, const std::vector<double>& spacing,
             const CArray<Index>& cells)
      : dimensions_(shape.size()), set_(make(grid_of(shape, spacing), cells)) {}

  // The places of cells in the set, -1 for those that it does not hold.
  py::array_t<Index> find(const CArray<Index>& cells) const {
    require(cells.ndim() == 1);
    py::array_t<Index> places(cells.size());
    Index* to = places.mutable_data();
    const ReleaseIf release(cells.size() >= kManyCells);
    std::transform(cells.data(), cells.data() + cells.size(), to, [this](Index cell) {
      const CellSet::Place place = set_.find(cell);
      return place == set_.missing() ? Index(-1) : static_cast<Index>(place);
    });
    return places;
  }

  py::array_t<double> march(const CArray<double>& speed, const CArray<Index>& cells,
                            const CArray<double>& times, double source_radius, Index stop) const {
    require(source_radius >= 0.0 && (source_radius == 0.0 || cells.size() == 1));
    std::vector<Source> sources = sources_of(cells, times);
    std::vector<double> arrival;
    {
      const py::gil_scoped_release release;
      require_speeds(speed);
      if (source_radius > 0.0) sources = with_ball(set_, speed.data(), sources[0], source_radius);
      arrival = march_second_order(set_, speed.data(), sources, stop);
    }
    return moved_array(std::move(arrival));
  }

  // What waves from both ends tell, each end with a flag: whether it lies outside.
  py::tuple waves(const CArray<double>& speed, const std::array<CArray<Index>, 2>& entries,
                  const std::array<CArray<double>, 2>& times,
                  const std::array<bool, 2>& are_outside, double reach) const {
    require(reach >= 0.0);
    std::array<WayEnd, 2> ends;
    for (std::size_t n = 0; n < 2; ++n) {
      ends[n] = {sources_of(entries[n], times[n]), are_outside[n]};
      require(are_outside[n] || ends[n].entries.size() == 1);
    }
    Waves found;
    {
      const py::gil_scoped_release release;
      require_speeds(speed);
      found = waves_between(set_, speed.data(), ends[0], ends[1], reach);
    }
    return py::make_tuple(moved_array(std::move(found.through)), found.arrival, found.is_open);
  }

  py::tuple follow_down(const CArray<double>& arrival, const std::vector<double>& start,
                        const std::vector<double>& goal, double step) const {
    require(arrival.ndim() == 1 && static_cast<std::size_t>(arrival.size()) == set_.size());
    const Coordinates from = leading_zero(start), to = leading_zero(goal);
    Descent descent;
    {
      const py::gil_scoped_release release;
      descent = descend(set_, arrival.data(), from, to, step);
    }
    py::array_t<double> path({descent.path.size(), dimensions_});
    double* target = path.mutable_data();
    for (const Coordinates& p : descent.path)
      target = std::copy(p.end() - static_cast<std::ptrdiff_t>(dimensions_), p.end(), target);
    return py::make_tuple(name(descent.status), path);
  }

  bool is_open(const CArray<double>& times) const {
    require(times.ndim() == 1 && static_cast<std::size_t>(times.size()) == set_.size());
    const ReleaseIf release(times.size() >= kManyCells);
    return set_.is_open(times.data());
  }

  py::array_t<double> distances(const CArray<bool>& mask) const {
    require(mask.ndim() == 1 && static_cast<std::size_t>(mask.size()) == set_.size());
    return transformed(reinterpret_cast<const std::uint8_t*>(mask.data()), Outside::kUnknown);
  }

  py::array_t<double> depths() const {
    const std::vector<std::uint8_t> none(set_.size(), 0);
    return transformed(none.data(), Outside::kTarget);
  }

 private:
  static CellSet make(const Grid& grid, const CArray<Index>& cells) {
    const ReleaseIf release(cells.size() >= kManyCells);
    return {grid, ascending_cells(grid, cells)};
  }

  static std::vector<Source> sources_of(const CArray<Index>& cells, const CArray<double>& times) {
    require(cells.ndim() == 1 && times.ndim() == 1 && cells.size() == times.size());
    std::vector<Source> sources;
    for (py::ssize_t n = 0; n < cells.size(); ++n) {
      require(times.at(n) >= 0.0 && std::isfinite(times.at(n)));
      sources.push_back({cells.at(n), times.at(n)});
    }
    return sources;
  }

  void require_speeds(const CArray<double>& speed) const {
    require(speed.ndim() == 1 && static_cast<std::size_t>(speed.size()) == set_.size());
    const double *first = speed.data(), *last = first + speed.size();
    require(std::all_of(first, last, [](double v) { return std::isfinite(v) && v >= 0.0; }));
    require(std::any_of(first, last, [](double v) { return v > 0.0; }));
  }

  Coordinates leading_zero(const std::vector<double>& coordinates) const {
    require(coordinates.size() == dimensions_);
    Coordinates result{};
    std::copy_backward(coordinates.begin(), coordinates.end(), result.end());
    return result;
  }

  py::array_t<double> transformed(const std::uint8_t* mask, Outside outside) const {
    std::vector<double> found;
    {
      const py::gil_scoped_release release;
      found = distance_transform(set_, mask, outside);
    }
    return moved_array(std::move(found));
  }

  std::size_t dimensions_;
  CellSet set_;
};

py::array_t<Index> widened(const std::vector<Index>& shape, const std::vector<double>& spacing,
                           const CArray<Index>& cells, double radius) {
  require(std::isfinite(radius) && radius >= 0.0);
  const Grid grid = grid_of(shape, spacing);
  std::vector<Index> found;
  {
    const py::gil_scoped_release release;
    found = cells_within(grid, ascending_cells(grid, cells), radius);
  }
  return moved_array(std::move(found));
}

py::array_t<Index> refined(const std::vector<Index>& coarse_shape,
                           const std::vector<Index>& fine_shape, const CArray<Index>& cells) {
  const std::vector<double> unit(coarse_shape.size(), 1.0);
  const Grid coarse = grid_of(coarse_shape, unit), fine = grid_of(fine_shape, unit);
  for (int axis = 0; axis < 3; ++axis) require(coarse.shape[axis] == (fine.shape[axis] + 1) / 2);
  std::vector<Index> found;
  {
    const ReleaseIf release(cells.size() >= kManyCells);
    found = finer_cells(coarse, fine, ascending_cells(coarse, cells));
  }
  return moved_array(std::move(found));
}

}  // namespace

void bind_cells(py::module_& module) {
  py::class_<BoundCells>(module, "CellSet")
      .def(py::init<const std::vector<Index>&, const std::vector<double>&, const CArray<Index>&>(),
           py::arg("shape"), py::arg("spacing"), py::arg("cells").noconvert())
      .def("find", &BoundCells::find, py::arg("cells").noconvert())
      .def("march", &BoundCells::march, py::arg("speed").noconvert(), py::arg("cells").noconvert(),
           py::arg("times").noconvert(), py::arg("source_radius"), py::arg("stop"))
      .def("waves", &BoundCells::waves, py::arg("speed").noconvert(), py::arg("cells"),
           py::arg("times"), py::arg("are_outside"), py::arg("reach"))
      .def("descend", &BoundCells::follow_down, py::arg("arrival").noconvert(), py::arg("start"),
           py::arg("goal"), py::arg("step"))
      .def("is_open", &BoundCells::is_open, py::arg("times").noconvert())
      .def("distances", &BoundCells::distances, py::arg("mask").noconvert())
      .def("depths", &BoundCells::depths);
  module.def("cells_within", &widened, py::arg("shape"), py::arg("spacing"),
             py::arg("cells").noconvert(), py::arg("radius"));
  module.def("finer_cells", &refined, py::arg("coarse_shape"), py::arg("fine_shape"),
             py::arg("cells").noconvert());
}

}  // namespace leadthrough
