#include "leadthrough/dmp/primitive.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough::dmp {

namespace {

// A phase nearer than this to a node counts as equal, as a fraction of an interval: rounding.
constexpr double kAtNode = 1e-9;

// Calls work with a number of channels. The six of a pose are known when compiling: their loops
// unroll.
template <typename Work>
void with_channels(Eigen::Index channels, const Work& work) {
  if (channels == 6)
    work(std::integral_constant<Eigen::Index, 6>{});
  else
    work(channels);
}

// Of a number that is not negative and far below 2^63; quicker than std::floor.
double floored(double x) { return static_cast<double>(static_cast<std::int64_t>(x)); }

// Writes a state plus `sign` times r and dr/du to another, which may be the same.
template <typename Channels>
void add_reference(Channels channels, Walk& reference, double phase, double sign, const State& from,
                   State& to) {
  const double* c = nullptr;
  const double s = reference.place_in_piece(phase, &c);
  const double slope_sign = phase < reference.end() ? sign : 0.0;
  for (Eigen::Index i = 0; i < channels; ++i) {
    double value = c[5 * channels + i];
    double slope = 0.0;
    for (Eigen::Index power = 4; power >= 0; --power) {
      slope = slope * s + value;
      value = value * s + c[power * channels + i];
    }
    to.value[i] = from.value[i] + sign * value;
    to.slope[i] = from.slope[i] + slope_sign * slope;
  }
}

// Linear map of an error over an interval of phase in which the force is a straight line: from its
// value and slope, and from the force and its slope, at the beginning.
struct Stretch {
  Stretch(double rate, double length) {
    const double x = rate * length;
    const double decay = std::exp(-x);
    const double compliance = 1.0 / (rate * rate);
    const double settled = 1.0 - decay * (1.0 + x);
    value_of_value = decay * (1.0 + x);
    value_of_slope = slope_of_force = decay * length;
    value_of_force = slope_of_rise = compliance * settled;
    value_of_rise = compliance * (x * (1.0 - decay) - 2.0 * settled) / rate;
    slope_of_value = -decay * rate * x;
    slope_of_slope = decay * (1.0 - x);
  }

  double value_of_value, value_of_slope, value_of_force, value_of_rise;
  double slope_of_value, slope_of_slope, slope_of_force, slope_of_rise;
};

void follow(const Stretch& t, double force, double rise, double& error, double& slope) {
  const double before = error;
  error = t.value_of_value * before + t.value_of_slope * slope + t.value_of_force * force +
          t.value_of_rise * rise;
  slope = t.slope_of_value * before + t.slope_of_slope * slope + t.slope_of_force * force +
          t.slope_of_rise * rise;
}

// Advances errors. Quantities that are constant over steps are computed once.
template <typename Channels>
class Motion {
 public:
  Motion(Channels channels, const Forces& forces, const Course& course, const Vector& push)
      : channels_(channels),
        forces_(forces),
        course_(course),
        push_(push),
        count_(forces.nodes.rows() - 1),
        intervals_(static_cast<double>(count_)),
        whole_interval_(stretch(1.0)) {}

  // From one phase to a later one.
  void advance(double from, double to, State& error) const {
    const double place = at_node(intervals_ * from), target = at_node(intervals_ * to);
    if (target - place > kIntervalsPerCheck)
      advance_far(place, target, error);
    else
      pass(place, target, target, error);
  }

 private:
  static constexpr double kIntervalsPerCheck = 256.0;

  // Over many periods.
  [[gnu::noinline, gnu::cold]] void advance_far(double place, double target, State& error) const {
    while (place < target) {
      check_interrupt();
      place = pass(place, std::min(floored(place) + kIntervalsPerCheck, target), target, error);
    }
  }

  // Interval by interval until `stop` is reached; the place, at most the target.
  double pass(double place, double stop, double target, State& error) const {
    const bool ends = forces_.canonical == Canonical::kDiscrete;
    while (place < stop) {
      const double node = floored(place);
      const bool free = ends && node >= intervals_;
      const double next = free ? target : std::min(node + 1.0, target);
      const Stretch& current = next - place == 1.0 ? whole_interval_ : stretch(next - place);
      if (free)
        fade_out(current, error);
      else
        follow_forces(current, node, place - node, error);
      place = next;
    }
    return place;
  }

  static double at_node(double place) {
    const double nearest = floored(place + 0.5);
    return std::abs(place - nearest) < kAtNode ? nearest : place;
  }

  Stretch stretch(double intervals) const { return {forces_.rate, intervals / intervals_}; }

  void fade_out(const Stretch& current, State& error) const {
    for (Eigen::Index i = 0; i < channels_; ++i)
      follow(current, push_[i], 0.0, error.value[i], error.slope[i]);
  }

  // `share`: elapsed fraction of the interval after the node.
  void follow_forces(const Stretch& current, double node, double share, State& error) const {
    const auto passed = static_cast<Eigen::Index>(node);
    const Eigen::Index row = passed < count_ ? passed : passed % count_;
    const double* left = forces_.nodes.data() + row * channels_;
    const double* right = left + channels_;
    const double fade = forces_.fade[row];
    const double fade_rise = forces_.fade[row + 1] - fade;
    const double* gain = course_.gain.data();
    const double* drive = course_.drive.data();
    const double* push = push_.data();
    double* value = error.value.data();
    double* slope = error.slope.data();
    for (Eigen::Index i = 0; i < channels_; ++i) {
      const double at_node = gain[i] * left[i] + drive[i] * fade;
      const double rise = gain[i] * (right[i] - left[i]) + drive[i] * fade_rise;
      follow(current, at_node + share * rise + push[i], intervals_ * rise, value[i], slope[i]);
    }
  }

  Channels channels_;
  const Forces& forces_;
  const Course& course_;
  const Vector& push_;
  Eigen::Index count_;
  double intervals_;
  Stretch whole_interval_;
};

}  // namespace

void advance(const Forces& forces, const Course& course, const Vector& push, double span,
             State& state) {
  with_channels(state.value.size(), [&](auto channels) {
    Walk reference(course.reference);
    add_reference(channels, reference, state.phase, -1.0, state, state);
    Motion(channels, forces, course, push).advance(state.phase, state.phase + span, state);
    state.phase += span;
    add_reference(channels, reference, state.phase, 1.0, state, state);
  });
}

void acceleration(const Forces& forces, const Course& course, const State& state, Vector& result) {
  const double* c = nullptr;
  const double s = place_in_piece(course.reference, state.phase, &c);
  const Eigen::Index channels = course.reference.coefficients.cols();
  const bool moves = state.phase < course.reference.end();
  const auto intervals = static_cast<double>(forces.nodes.rows() - 1);
  const bool rhythmic = forces.canonical == Canonical::kRhythmic;
  const bool forced = state.phase < 1.0 || rhythmic;
  const double turn = state.phase < 1.0 ? 0.0 : std::floor(state.phase);
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

void check_run(const Forces& forces, const Course& course, const State& state,
               const VectorRef& phases) {
  const Eigen::Index channels = forces.nodes.cols();
  check_argument(course.reference.coefficients.cols() == channels &&
                     state.value.size() == channels && state.slope.size() == channels,
                 "course, state: expected the channels of the forces");
  check_argument(phases.size() > 0 && (phases.array() >= 0.0 && phases.array() <= kMaxPhase).all(),
                 "phases: expected 0 to kMaxPhase");
}

void roll(const Forces& forces, const Course& course, State state, const VectorRef& phases,
          const std::function<void(Eigen::Index, const State&)>& take) {
  check_run(forces, course, state, phases);
  const Vector no_push = Vector::Zero(state.value.size());
  with_channels(state.value.size(), [&](auto channels) {
    const Motion motion(channels, forces, course, no_push);
    State error = state;
    Walk reference(course.reference);
    add_reference(channels, reference, phases[0], -1.0, state, error);
    for (Eigen::Index n = 0; n < phases.size(); ++n) {
      check_interrupt(n);
      if (n > 0) motion.advance(phases[n - 1], phases[n], error);
      add_reference(channels, reference, phases[n], 1.0, error, state);
      take(n, state);
    }
  });
}

Rollout rollout(const Forces& forces, const Course& course, State state, const VectorRef& phases) {
  const Eigen::Index channels = state.value.size();
  Rollout result{Rows(phases.size(), channels), Rows(phases.size(), channels)};
  roll(forces, course, std::move(state), phases, [&](Eigen::Index n, const State& at) {
    result.values.row(n) = at.value;
    result.slopes.row(n) = at.slope;
  });
  return result;
}

}  // namespace leadthrough::dmp
