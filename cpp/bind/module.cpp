#include <cstddef>
#include <cstdlib>
#include <exception>
#include <string_view>

#include "bind/parts.hpp"

namespace {

// glibc returns freed memory to the system where it is more than twice the largest block freed so
// far, and to get it anew takes as long as to compute in it: a tenth of a plan's time. Hosts that
// tune malloc themselves set LEADTHROUGH_MALLOC=system.
void keep_freed_memory() {
  const char* const malloc_of = std::getenv("LEADTHROUGH_MALLOC");
  if (malloc_of && std::string_view(malloc_of) == "system") return;
  constexpr std::size_t kMax = std::size_t{1} << 22;
  void* volatile block = std::malloc(kMax);
  std::free(block);
}

void raise_interrupted(std::exception_ptr thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const leadthrough::Interrupted&) {
    // The handler's own error is set already.
  }
}

[[noreturn]] void* refuse_to_fill(std::size_t /*size*/) {
  throw pybind11::type_error("an object whose __init__ was not called");
}

// Functions given an object made by __new__ alone would read memory that nobody has filled:
// pybind11 allocates it by this.
void refuse_empty_objects(const pybind11::module_& module) {
  for (const auto& entry : pybind11::dict(module.attr("__dict__"))) {
    if (!PyType_Check(entry.second.ptr())) continue;
    auto* const type = reinterpret_cast<PyTypeObject*>(entry.second.ptr());
    pybind11::detail::get_type_info(type)->operator_new = &refuse_to_fill;
  }
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  module.doc() = "Numeric kernels of leadthrough; arguments are checked by the Python layer above.";
  keep_freed_memory();
  pybind11::register_local_exception_translator(&raise_interrupted);
  leadthrough::bind_base(module);
  leadthrough::bind_rotation(module);
  leadthrough::bind_learn(module);
  leadthrough::bind_time(module);
  leadthrough::bind_arm(module);
  leadthrough::bind_collision(module);  // before those that take shapes
  leadthrough::bind_speeds(module);
  leadthrough::bind_field(module);
  leadthrough::bind_guard(module);
  leadthrough::bind_ik(module);
  leadthrough::bind_priority(module);
  leadthrough::bind_simulation(module);
  leadthrough::bind_path(module);
  leadthrough::bind_dmp(module);
  refuse_empty_objects(module);
}
