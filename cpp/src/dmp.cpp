#include "leadthrough/dmp.hpp"

#include <algorithm>
#include <cmath>

namespace leadthrough::dmp {

namespace {

// As near as this a place is at a node, as a share of an interval: rounding.
constexpr double kAtNode = 1e-9;

// Phase since the break before it, and the coefficients that hold there.
double place_in_piece(const Course& course, double phase, const double** coefficients) {
  const double* first = course.breaks.data() + 1;
  const Eigen::Index pieces = course.breaks.size() - 1;
  const Eigen::Index piece = std::upper_bound(first, first + pieces - 1, phase) - first;
  *coefficients = course.coefficients.data() + 6 * piece * course.coefficients.cols();
  return std::min(phase, 1.0) - course.breaks[piece];
}

// Adds `sign` times r and dr/du to a value and its slope.
void add_reference(const Course& course, double phase, double sign, State& state) {
  const double* c = nullptr;
  const double s = place_in_piece(course, phase, &c);
  const double slope_sign = phase < 1.0 ? sign : 0.0;
  const Eigen::Index channels = course.coefficients.cols();
  for (Eigen::Index i = 0; i < channels; ++i) {
    double value = c[5 * channels + i];
    double slope = 0.0;
    for (Eigen::Index power = 4; power >= 0; --power) {
      slope = slope * s + value;
      value = value * s + c[power * channels + i];
    }
    state.value[i] += sign * value;
    state.slope[i] += slope_sign * slope;
  }
}

// A stretch of phase over which the force is a straight line.
struct Stretch {
  double length, decay;        // decay: exp(-rate * length)
  double compliance, inverse;  // 1 / rate^2, 1 / rate
};

// e = p0 + p1 s + (w + k s) exp(-rate s): the polynomial follows the force, the rest dies out.
void follow(const Stretch& stretch, double rate, double force, double force_slope, double& error,
            double& error_slope) {
  const double p1 = stretch.compliance * force_slope;
  const double p0 = stretch.compliance * force - 2.0 * p1 * stretch.inverse;
  const double w = error - p0;
  const double w_slope = error_slope - p1;
  const double k = w_slope + rate * w;
  error = p0 + p1 * stretch.length + (w + k * stretch.length) * stretch.decay;
  error_slope = p1 + (w_slope - rate * k * stretch.length) * stretch.decay;
}

// Moves errors on. What does not change from step to step is computed once.
class Motion {
 public:
  Motion(const Forces& forces, const Course& course, const Vector& push)
      : forces_(forces),
        course_(course),
        push_(push),
        intervals_(static_cast<double>(forces.nodes.rows() - 1)),
        whole_interval_(stretch(1.0)) {}

  // From one phase to a later one.
  void advance(double from, double to, State& error) const {
    const bool ends = forces_.canonical == Canonical::Discrete;
    const double target = at_node(intervals_ * to);
    double place = at_node(intervals_ * from);
    while (place < target) {
      const double node = std::floor(place);
      const bool free = ends && node >= intervals_;
      const double next = free ? target : std::min(node + 1.0, target);
      const Stretch current = next - place == 1.0 ? whole_interval_ : stretch(next - place);
      if (free)
        fade_out(current, error);
      else
        follow_forces(current, node, place - node, error);
      place = next;
    }
  }

 private:
  static double at_node(double place) {
    const double nearest = std::round(place);
    return std::abs(place - nearest) < kAtNode ? nearest : place;
  }

  Stretch stretch(double intervals) const {
    const double length = intervals / intervals_;
    const double inverse = 1.0 / forces_.rate;
    return {length, std::exp(-forces_.rate * length), inverse * inverse, inverse};
  }

  void fade_out(const Stretch& current, State& error) const {
    for (Eigen::Index i = 0; i < push_.size(); ++i)
      follow(current, forces_.rate, push_[i], 0.0, error.value[i], error.slope[i]);
  }

  // `share` of the interval after the node has passed already.
  void follow_forces(const Stretch& current, double node, double share, State& error) const {
    const Eigen::Index channels = forces_.nodes.cols();
    const auto row = static_cast<Eigen::Index>(std::fmod(node, intervals_));
    const double* left = forces_.nodes.data() + row * channels;
    const double* right = left + channels;
    const double fade = forces_.fade[row];
    const double fade_rise = forces_.fade[row + 1] - fade;
    for (Eigen::Index i = 0; i < channels; ++i) {
      const double at_node = course_.gain[i] * left[i] + course_.drive[i] * fade;
      const double rise = course_.gain[i] * (right[i] - left[i]) + course_.drive[i] * fade_rise;
      follow(current, forces_.rate, at_node + share * rise + push_[i], intervals_ * rise,
             error.value[i], error.slope[i]);
    }
  }

  const Forces& forces_;
  const Course& course_;
  const Vector& push_;
  double intervals_;
  Stretch whole_interval_;
};

}  // namespace

void advance(const Forces& forces, const Course& course, const Vector& push, double span,
             State& state) {
  add_reference(course, state.phase, -1.0, state);
  Motion(forces, course, push).advance(state.phase, state.phase + span, state);
  state.phase += span;
  add_reference(course, state.phase, 1.0, state);
}

void acceleration(const Forces& forces, const Course& course, const State& state, Vector& result) {
  const double* c = nullptr;
  const double s = place_in_piece(course, state.phase, &c);
  const Eigen::Index channels = course.coefficients.cols();
  const bool moves = state.phase < 1.0;
  const auto intervals = static_cast<double>(forces.nodes.rows() - 1);
  const bool forced = moves || forces.canonical == Canonical::Rhythmic;
  const double turn = moves ? 0.0 : std::floor(state.phase);
  const double place = forced ? intervals * (state.phase - turn) : 0.0;
  const auto node = std::min(static_cast<Eigen::Index>(place), forces.nodes.rows() - 2);
  const double share = place - static_cast<double>(node);
  const double fade = (1.0 - share) * forces.fade[node] + share * forces.fade[node + 1];
  for (Eigen::Index i = 0; i < channels; ++i) {
    double r = 0.0, slope = 0.0, half_bend = 0.0;
    for (Eigen::Index power = 5; power >= 0; --power) {
      half_bend = half_bend * s + slope;
      slope = slope * s + r;
      r = r * s + c[power * channels + i];
    }
    const double learned =
        (1.0 - share) * forces.nodes(node, i) + share * forces.nodes(node + 1, i);
    const double force = forced ? course.gain[i] * learned + course.drive[i] * fade : 0.0;
    const double error_slope = state.slope[i] - (moves ? slope : 0.0);
    result[i] = (moves ? 2.0 * half_bend : 0.0) + force -
                forces.rate * (2.0 * error_slope + forces.rate * (state.value[i] - r));
  }
}

Rollout rollout(const Forces& forces, const Course& course, State state,
                const Eigen::Ref<const Vector>& phases) {
  const Eigen::Index count = phases.size();
  const Vector no_push = Vector::Zero(state.value.size());
  const Motion motion(forces, course, no_push);
  Rollout result{Rows(count, state.value.size()), Rows(count, state.value.size())};
  State error = state;
  add_reference(course, phases[0], -1.0, error);
  for (Eigen::Index n = 0; n < count; ++n) {
    if (n > 0) motion.advance(phases[n - 1], phases[n], error);
    state.value = error.value;
    state.slope = error.slope;
    add_reference(course, phases[n], 1.0, state);
    result.values.row(n) = state.value;
    result.slopes.row(n) = state.slope;
  }
  return result;
}

}  // namespace leadthrough::dmp
