#pragma once

#include <Eigen/Core>
#include <array>

namespace leadthrough {

// Solutions of the upwind equation, sum of ((T - value) / spacing)^2 over the axes where T > value
// = step^2, for many cells at once and without a branch: axes are added from the smallest value on,
// and a value above the solution so far is clamped to it, which leaves the solution unchanged.
// Differences to the smallest value preserve the digits far from the source.
template <typename Value>
Value solve_cubes(const std::array<Value, 2>& upwind, const Value& step) {
  using Real = typename Value::Scalar;
  const Value least = upwind[0].min(upwind[1]);
  const Value d = (upwind[0].max(upwind[1]) - least).min(step);
  return least + Real(0.5) * (d + (Real(2) * step * step - d * d).sqrt());
}

template <typename Value>
Value solve_cubes(const std::array<Value, 3>& upwind, const Value& step) {
  using Real = typename Value::Scalar;
  const Value low = upwind[0].min(upwind[1]);
  const Value high = upwind[0].max(upwind[1]);
  const Value least = low.min(upwind[2]);
  const Value middle = low.max(high.min(upwind[2]));
  const Value most = high.max(upwind[2]);
  const Value d = (middle - least).min(step);
  const Value two = Real(0.5) * (d + (Real(2) * step * step - d * d).sqrt());
  const Value e = (most - least).min(two);
  const Value rest = Real(3) * step * step - d * d - e * e - (e - d) * (e - d);
  return least + Real(1.0 / 3.0) * (d + e + rest.max(Real(0)).sqrt());
}

template <typename Value>
struct Term {
  Value value;
  Value spacing;
};

template <typename Value>
void sort(Term<Value>& a, Term<Value>& b) {
  const auto swapped = (b.value < a.value).eval();
  const Value spacing = swapped.select(b.spacing, a.spacing);
  b.spacing = swapped.select(a.spacing, b.spacing);
  a.spacing = spacing;
  const Value least = a.value.min(b.value);
  b.value = a.value.max(b.value);
  a.value = least;
}

// The same for any spacing.
template <typename Value, std::size_t D>
Value solve_boxes(const std::array<Value, D>& upwind,
                  const std::array<typename Value::Scalar, D>& spacing, const Value& step) {
  using Real = typename Value::Scalar;
  std::array<Term<Value>, D> terms;
  for (std::size_t axis = 0; axis < D; ++axis)
    terms[axis] = {upwind[axis], Value::Constant(spacing[axis])};
  sort(terms[0], terms[1]);
  if constexpr (D == 3) {
    sort(terms[1], terms[2]);
    sort(terms[0], terms[1]);
  }
  const Value least = terms[0].value;
  Value weights = terms[0].spacing.square().inverse();  // their sum, and that of ...
  Value first = Value::Zero();                          // ... weight * difference
  Value second = Value::Zero();                         // ... weight * difference^2
  Value solution = step * terms[0].spacing;
  for (std::size_t n = 1; n < D; ++n) {
    const Value weight = terms[n].spacing.square().inverse();
    const Value difference = (terms[n].value - least).min(solution);
    weights += weight;
    first += weight * difference;
    second += weight * difference.square();
    const Value rest = first.square() - weights * (second - step.square());
    solution = (first + rest.max(Real(0)).sqrt()) / weights;
  }
  return least + solution;
}

}  // namespace leadthrough
