#pragma once

// Controllers of joints: springs and dampers, with torques from the arm's model added or not.

#include <Eigen/Core>

#include "leadthrough/arm/dynamics.hpp"

namespace leadthrough::simulation {

// Inputs of a controller at the beginning of a period, one value a joint each.
struct Moment {
  Eigen::VectorXd target_q, target_qd;  // commanded now
  Eigen::VectorXd qdd;                  // commanded until the next period
  Eigen::VectorXd q, qd;                // measured
  double progress = 0.0;                // fraction of the path that the tip has gone
};

// From the arm's model comes nothing, the torques against gravity, or those of the whole motion.
enum class Model { none, weight, motion };

struct JointGains {
  double stiffness = 0.0, damping = 0.0;  // of errors in the motion's acceleration, 1/s^2 and 1/s
  Eigen::VectorXd springs, dampers;       // of the joints, N m/rad and N m s/rad (N/m, N s/m)
};

// Computed torque, Siciliano et al. 2009, section 8.5.2; joint impedance, Albu-Schaeffer, Ott and
// Hirzinger 2007; or a servo, by its model and gains. For one thread.
class JointLaw {
 public:
  // rotors: inertias of the motors behind their gears, kg m^2 (kg).
  JointLaw(const Dynamics& dynamics, const Eigen::Vector3d& gravity, Eigen::VectorXd rotors,
           JointGains gains, Model model);

  Eigen::Index joints() const { return rotors_.size(); }

  // N m (N), for one period.
  const Eigen::VectorXd& torques(const Moment& now);

 private:
  InverseDynamics dynamics_;
  Eigen::VectorXd rotors_, still_, wanted_, torques_;
  JointGains gains_;
  Model model_;
};

}  // namespace leadthrough::simulation
