#include "leadthrough/dmp.hpp"

#include <algorithm>
#include <cmath>

namespace leadthrough::dmp {

namespace {

// What rounding may leave before a node that was reached, as a share of an interval.
constexpr double kAtNode = 1e-9;

// Adds `sign` times r and dr/du to a value and its slope.
void add_reference(const Course& course, double phase, double sign, State& state) {
  const double* first = course.breaks.data() + 1;
  const Eigen::Index pieces = course.breaks.size() - 1;
  const Eigen::Index piece = std::upper_bound(first, first + pieces - 1, phase) - first;
  const double s = std::min(phase, 1.0) - course.breaks[piece];
  const double slope_sign = phase < 1.0 ? sign : 0.0;
  const Eigen::Index channels = course.coefficients.cols();
  const double* c = course.coefficients.data() + 6 * piece * channels;
  for (Eigen::Index i = 0; i < channels; ++i) {
    double value = 0.0;
    double slope = 0.0;
    for (Eigen::Index power = 5; power >= 0; --power) {
      slope = slope * s + value;
      value = value * s + c[power * channels + i];
    }
    state.value[i] += sign * value;
    state.slope[i] += slope_sign * slope;
  }
}

// The force over a stretch of phase: at its beginning, and its slope.
struct Ramp {
  double value, slope;
};

// e = p0 + p1 s + (w + k s) exp(-rate s): the polynomial follows the ramp, the rest dies out.
void follow(const Ramp& ramp, double rate, double length, double decay, double& error,
            double& error_slope) {
  const double compliance = 1.0 / (rate * rate);
  const double p1 = compliance * ramp.slope;
  const double p0 = compliance * ramp.value - 2.0 * p1 / rate;
  const double w = error - p0;
  const double w_slope = error_slope - p1;
  const double k = w_slope + rate * w;
  error = p0 + p1 * length + (w + k * length) * decay;
  error_slope = p1 + (w_slope - rate * k * length) * decay;
}

// Moves an error, held in the state, through one stretch inside an interval, or beyond the last.
void follow_forces(const Forces& forces, const Course& course, const Vector& push, double place,
                   double length, double decay, State& error) {
  const Eigen::Index intervals = forces.nodes.rows() - 1;
  const Eigen::Index channels = forces.nodes.cols();
  const double whole = std::floor(place + kAtNode);
  if (forces.canonical == Canonical::Discrete && whole >= static_cast<double>(intervals)) {
    for (Eigen::Index i = 0; i < channels; ++i)
      follow({push[i], 0.0}, forces.rate, length, decay, error.value[i], error.slope[i]);
    return;
  }
  const auto node = static_cast<Eigen::Index>(std::fmod(whole, static_cast<double>(intervals)));
  const double share = std::max(place - whole, 0.0);
  const double per_phase = static_cast<double>(intervals);
  const double* left = forces.nodes.data() + node * channels;
  const double* right = left + channels;
  const double fade = forces.fade[node];
  const double fade_rise = forces.fade[node + 1] - fade;
  for (Eigen::Index i = 0; i < channels; ++i) {
    const double rise = course.gain[i] * (right[i] - left[i]) + course.drive[i] * fade_rise;
    const double at_node = course.gain[i] * left[i] + course.drive[i] * fade;
    follow({at_node + share * rise + push[i], per_phase * rise}, forces.rate, length, decay,
           error.value[i], error.slope[i]);
  }
}

}  // namespace

void advance(const Forces& forces, const Course& course, const Vector& push, double span,
             State& state) {
  add_reference(course, state.phase, -1.0, state);
  const auto intervals = static_cast<double>(forces.nodes.rows() - 1);
  const bool ends = forces.canonical == Canonical::Discrete;
  const double target = intervals * (state.phase + span);
  double place = intervals * state.phase;
  while (place < target) {
    const double node_end = std::floor(place + kAtNode) + 1.0;
    const bool last = node_end > target - kAtNode || (ends && node_end > intervals);
    const double next = last ? target : node_end;
    const double length = (next - place) / intervals;
    follow_forces(forces, course, push, place, length, std::exp(-forces.rate * length), state);
    place = next;
  }
  state.phase += span;
  add_reference(course, state.phase, 1.0, state);
}

Rollout rollout(const Forces& forces, const Course& course, State state,
                const Eigen::Ref<const Vector>& phases) {
  const Eigen::Index count = phases.size();
  const Vector no_push = Vector::Zero(state.value.size());
  Rollout result{Rows(count, state.value.size()), Rows(count, state.value.size())};
  for (Eigen::Index n = 0; n < count; ++n) {
    if (n > 0) advance(forces, course, no_push, phases[n] - phases[n - 1], state);
    result.values.row(n) = state.value;
    result.slopes.row(n) = state.slope;
  }
  return result;
}

}  // namespace leadthrough::dmp
