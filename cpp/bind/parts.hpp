#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/base/matrix.hpp"

#ifdef __linux__
#include <unistd.h>
#endif

namespace leadthrough {

void bind_arm(pybind11::module_& module);
void bind_base(pybind11::module_& module);
void bind_collision(pybind11::module_& module);
void bind_dmp(pybind11::module_& module);
void bind_field(pybind11::module_& module);
void bind_guard(pybind11::module_& module);
void bind_ik(pybind11::module_& module);
void bind_learn(pybind11::module_& module);
void bind_path(pybind11::module_& module);
void bind_priority(pybind11::module_& module);
void bind_rotation(pybind11::module_& module);
void bind_simulation(pybind11::module_& module);
void bind_speeds(pybind11::module_& module);
void bind_time(pybind11::module_& module);

using namespace pybind11::literals;

// An argument that is an array of this type already, and is never copied to become one.
inline pybind11::arg operator""_array(const char* name, std::size_t /*length*/) {
  return pybind11::arg(name).noconvert();
}

// The Python layer reports errors; this check keeps the kernels inside their arrays.
inline void require(bool sizes_agree) {
  if (!sizes_agree) throw std::invalid_argument("sizes of the arrays and of the chain differ");
}

// Whether a signal's handler raises: Python runs handlers on its main thread only.
inline bool signal_raises() {
#ifdef __linux__
  if (gettid() != getpid()) return false;  // waits for the GIL no longer than it has to
#endif
  const pybind11::gil_scoped_acquire acquire;
  return PyErr_CheckSignals() != 0;
}

// Releases the GIL. Ctrl-C then ends the computation: Interrupted leaves the error that Python has.
class Unlocked {
  pybind11::gil_scoped_release release_;
  Interruptible call_{&signal_raises};
};

// Its value, computed without the GIL if that is worth it.
template <typename Compute>
auto without_gil(const Compute& compute, bool is_worth_it = true) {
  std::optional<Unlocked> scope;
  if (is_worth_it) scope.emplace();
  return compute();
}

// Of a function that is bound as it is.
using Unlocking = pybind11::call_guard<Unlocked>;

// Count of numbers whose reading takes longer than releasing and taking the GIL.
constexpr pybind11::ssize_t kLong = 10'000;

template <typename Parts>
std::vector<std::string> names_of(const Parts& parts) {
  std::vector<std::string> names;
  for (const auto& part : parts) names.push_back(part.name);
  return names;
}

template <typename Value>
pybind11::array_t<Value> as_array(const std::vector<Value>& values) {
  return pybind11::array_t<Value>(static_cast<pybind11::ssize_t>(values.size()), values.data());
}

// The vector's own memory as an array of a shape, or of one row.
template <typename Value>
pybind11::array_t<Value> moved_array(std::vector<Value>&& values,
                                     std::vector<pybind11::ssize_t> shape) {
  auto owner = std::make_unique<std::vector<Value>>(std::move(values));
  const pybind11::capsule memory(owner.get(),
                                 [](void* kept) { delete static_cast<std::vector<Value>*>(kept); });
  return pybind11::array_t<Value>(std::move(shape), owner.release()->data(), memory);
}

template <typename Value>
pybind11::array_t<Value> moved_array(std::vector<Value>&& values) {
  const auto size = static_cast<pybind11::ssize_t>(values.size());
  return moved_array(std::move(values), {size});
}

// One member of each of many records.
template <typename Number, typename Record, typename Member>
pybind11::array_t<Number> column(const std::vector<Record>& records, Member Record::* member) {
  pybind11::array_t<Number> numbers(static_cast<pybind11::ssize_t>(records.size()));
  std::transform(records.begin(), records.end(), numbers.mutable_data(),
                 [&](const Record& record) { return static_cast<Number>(record.*member); });
  return numbers;
}

// Makes records of the values of these members.
template <typename Record, typename... Values>
auto maker(Values Record::*... members) {
  return [members...](const Values&... values) {
    Record record{};
    ((record.*members = values), ...);
    return record;
  };
}

// A class of values, each given by its name.
template <typename Record, typename... Values>
void bind_record(pybind11::module_& module, const char* name,
                 const std::pair<const char*, Values Record::*>&... fields) {
  pybind11::class_<Record>(module, name)
      .def(pybind11::init(maker(fields.second...)), pybind11::arg(fields.first)...);
}

template <typename T>
using CArray = pybind11::array_t<T, pybind11::array::c_style>;

// Whether an object is a contiguous array of float64. Subclasses may mean something else, as masked
// arrays do.
inline bool is_plain_array(const pybind11::handle& object) {
  return Py_TYPE(object.ptr()) == pybind11::detail::npy_api::get().PyArray_Type_ &&
         pybind11::isinstance<CArray<double>>(object);
}

// The numbers of a contiguous vector of this many finite float64, which needs no other check; null
// for any other object.
inline const double* finite_vector(const pybind11::handle& object, pybind11::ssize_t size) {
  if (!is_plain_array(object)) return nullptr;
  const auto vector = pybind11::reinterpret_borrow<CArray<double>>(object);
  if (vector.ndim() != 1 || vector.shape(0) != size) return nullptr;
  const double* values = vector.data();
  const bool finite = std::all_of(values, values + size, [](double x) { return std::isfinite(x); });
  return finite ? values : nullptr;
}

// Orientations may have no rows.
inline bool orientations_fit(Eigen::Index rows, Eigen::Index orientations) {
  return orientations == rows || orientations == 0;
}

}  // namespace leadthrough
