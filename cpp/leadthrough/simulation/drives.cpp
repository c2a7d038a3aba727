#include "leadthrough/simulation/drives.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "leadthrough/base/argument.hpp"

namespace leadthrough::simulation {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

// No arm has such motors, N m (N); MuJoCo would soon give up and write a file about it.
constexpr double kStrongest = 1e6;

// The joint whose size is too large, or no number.
Index runaway(const VectorXd& sizes, double most) {
  Index worst = 0;
  for (Index i = 0; i < sizes.size(); ++i) {
    if (std::isnan(sizes[i])) return i;
    if (sizes[i] > sizes[worst]) worst = i;
  }
  return sizes[worst] < most ? kNone : worst;
}

double encoded(double q, double step) { return step > 0.0 ? std::nearbyint(q / step) * step : q; }

}  // namespace

Drives::Drives(DriveValues values, PhysicsState state, const Command& start)
    : values_(std::move(values)), state_(std::move(state)) {
  const Index n = joints();
  check_argument(n > 0 && static_cast<Index>(state_.joints.size()) == n, "joints: one index each");
  for (const VectorXd* each : {&values_.encoder, &values_.rotors, &values_.fed, &values_.dampers})
    check_argument(each->size() == n, "drives: one value a joint");
  check_argument(values_.steps > 0 && values_.period > 0.0, "steps and period: above 0");
  check_argument(values_.late >= 0 && values_.late < 100'000, "late: 0 to 100000 periods");
  check_argument(start.rows() == 3 && start.cols() == n, "start: rows (3, joints)");
  next_q_ = start.row(0);
  last_qd_ = mean_qd_ = next_qd_ = start.row(1);
  moment_ = {next_q_, next_qd_, next_qd_, next_q_, next_qd_, 0.0};
  last_seen_ = next_q_ - values_.period * next_qd_;
  VectorXd seen = next_q_;
  for (Index i = 0; i < n; ++i) {
    seen[i] = encoded(seen[i], values_.encoder[i]);
    last_seen_[i] = encoded(last_seen_[i], values_.encoder[i]);
  }
  seen_q_ = seen.transpose().replicate(values_.late + 1, 1);
  seen_qd_ = next_qd_.transpose().replicate(values_.late + 1, 1);
  asked_ = spin_ = speed_ = gained_ = summed_qd_ = summed_torques_ = torques_ = demanded_ =
      VectorXd::Zero(n);
}

void Drives::read(const double* all, double* result) const {
  for (std::size_t i = 0; i < state_.joints.size(); ++i) result[i] = all[state_.joints[i]];
}

// The controller sees encoded positions and their differences, late.
void Drives::measure() {
  const Index row = ticks_ % seen_q_.rows();
  read_q(speed_.data());
  for (Index i = 0; i < joints(); ++i) {
    const double seen = encoded(speed_[i], values_.encoder[i]);
    const double difference = (seen - last_seen_[i]) / values_.period;
    last_seen_[i] = seen_q_(row, i) = seen;
    seen_qd_(row, i) = values_.encoder[i] > 0.0 ? difference : mean_qd_[i];
  }
  const Index oldest = (ticks_ + 1) % seen_q_.rows();
  moment_.q = seen_q_.row(oldest);
  moment_.qd = seen_qd_.row(oldest);
}

Index Drives::begin(const Eigen::Ref<const Command>& command, double progress, const Law& law) {
  measure();
  moment_.target_q = next_q_;
  moment_.target_qd = next_qd_;
  moment_.qdd = command.row(2);
  moment_.progress = progress;
  law(moment_, asked_);
  next_q_ = command.row(0);
  next_qd_ = command.row(1);
  read_qd(speed_.data());
  // Torque limits hold behind the gears, where the rotors' own acceleration has no part: as fed
  // forward, or as in the last period.
  spin_ = values_.fed.cwiseProduct(moment_.qdd) +
          (values_.rotors - values_.fed).cwiseProduct((speed_ - last_qd_) / values_.period);
  last_qd_ = speed_;
  demanded_ = asked_ + values_.dampers.cwiseProduct(moment_.qd - speed_) - spin_;
  for (Index i = 0; i < joints(); ++i) {
    const double effort = values_.effort[i], size = std::abs(demanded_[i]);
    if (std::isfinite(effort)) {
      state_.ranges[2 * i] = spin_[i] - effort;
      state_.ranges[2 * i + 1] = spin_[i] + effort;
    }
    gained_[i] = effort < size ? effort : size;
  }
  summed_qd_.setZero();
  summed_torques_.setZero();
  return runaway(gained_, kStrongest);
}

// The drives subtract what their own dampers give. These compare velocities at the end of a step,
// with the target's there: between samples its acceleration is constant.
void Drives::act(int step) {
  const double length = values_.period / values_.steps;
  const double ahead = 0.5 * (values_.period - length) + (step + 1) * length;
  Eigen::Map<VectorXd>(state_.control, joints()) =
      asked_ + values_.dampers.cwiseProduct(moment_.qd + ahead * moment_.qdd);
}

Index Drives::advance() {
  gained_ = speed_;
  read_qd(speed_.data());
  gained_ = speed_ - gained_;
  summed_qd_ += speed_;
  for (Index i = 0; i < joints(); ++i) {
    const double force = state_.force[i] - spin_[i], limit = values_.effort[i];
    // Behind the gears; the drives' dampers act after the motors' limits.
    const double free = std::abs(force) < limit ? 1.0 : 0.0;
    const double given = force - free * values_.dampers[i] * gained_[i];
    summed_torques_[i] += std::min(std::max(given, -limit), limit);
  }
  gained_ = speed_.cwiseAbs();
  return runaway(gained_, values_.fastest);
}

void Drives::end() {
  mean_qd_ = summed_qd_ / values_.steps;
  torques_ = summed_torques_ / values_.steps;
  ++ticks_;
}

}  // namespace leadthrough::simulation
