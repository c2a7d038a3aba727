#pragma once

// Motors, gears and encoders of a simulated arm, which take a command every period.

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "leadthrough/base/matrix.hpp"
#include "leadthrough/simulation/joint_law.hpp"

namespace leadthrough::simulation {

// One value a joint each.
struct DriveValues {
  Eigen::VectorXd encoder;  // steps in which positions are measured, rad (m); 0: exactly
  Eigen::VectorXd rotors;   // kg m^2 (kg) behind the gears
  Eigen::VectorXd fed;      // the part of them whose acceleration the controller's torques contain
  Eigen::VectorXd effort;   // the motors' limits, N m (N), or infinite
  Eigen::VectorXd dampers;  // inside the drives, N m s/rad (N s/m)
  Eigen::Index late = 0;    // periods by which measurements are delayed
  double period = 1e-3;     // s
  int steps = 1;            // of the physics in a period
  double fastest = 1e3;     // rad/s (m/s), from which on a joint runs away
};

// Values of the physics in its own memory; those of motors are of the arm's alone, in its order.
struct PhysicsState {
  const double* q = nullptr;         // of all joints of the model
  const double* qd = nullptr;        // likewise
  std::vector<Eigen::Index> joints;  // those of the arm among them
  double* control = nullptr;         // torques asked of the motors
  double* ranges = nullptr;          // their limits, (joints, 2)
  const double* force = nullptr;     // that they gave in the last step
};

// Rows (3, joints): position and velocity at a period's end, and the acceleration during it.
using Command = Rows;

constexpr Eigen::Index kNone = -1;

class Drives {
 public:
  using Law = std::function<void(const Moment&, Eigen::VectorXd&)>;

  Drives(DriveValues values, PhysicsState state, const Command& start);

  // A period is begin(), then act(), the physics' step and advance() as often as there are steps,
  // then end(). They return the joint that runs away, or kNone.
  Eigen::Index begin(const Eigen::Ref<const Command>& command, double progress, const Law& law);
  void act(int step);
  Eigen::Index advance();
  void end();

  const DriveValues& values() const { return values_; }
  Eigen::Index joints() const { return values_.effort.size(); }
  long ticks() const { return ticks_; }                          // periods so far
  const Eigen::VectorXd& torques() const { return torques_; }    // behind the gears, in the last
  const Eigen::VectorXd& demanded() const { return demanded_; }  // of the motors, in the last

  // Positions or velocities of the arm's joints.
  void read_q(double* result) const { read(state_.q, result); }
  void read_qd(double* result) const { read(state_.qd, result); }

 private:
  void read(const double* all, double* result) const;
  void measure();

  DriveValues values_;
  PhysicsState state_;
  Moment moment_;
  Rows seen_q_, seen_qd_;  // the last measurements, the one of period k in row k % rows
  Eigen::VectorXd next_q_, next_qd_, last_seen_, last_qd_, mean_qd_;
  Eigen::VectorXd asked_, spin_, speed_, gained_, summed_qd_, summed_torques_, torques_, demanded_;
  long ticks_ = 0;
};

}  // namespace leadthrough::simulation
