#pragma once

#include <pybind11/pybind11.h>

namespace leadthrough {

void bind_alignment(pybind11::module_& module);
void bind_arm(pybind11::module_& module);
void bind_field(pybind11::module_& module);
void bind_so3(pybind11::module_& module);

}  // namespace leadthrough
