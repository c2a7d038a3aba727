#include <pybind11/numpy.h>

#include <cstddef>
#include <optional>

#include "bind/parts.hpp"
#include "leadthrough/base/finite.hpp"

namespace py = pybind11;

namespace leadthrough {

void bind_finite(py::module_& module) {
  // It keeps the GIL for most arrays: to let it go takes longer than they do.
  module.def(
      "all_finite",
      [](const py::array_t<double, py::array::c_style>& values) {
        std::optional<Unlocked> unlocked;
        if (values.size() >= kLong) unlocked.emplace();
        return all_finite(values.data(), static_cast<std::size_t>(values.size()));
      },
      py::arg("values").noconvert());
}

}  // namespace leadthrough
