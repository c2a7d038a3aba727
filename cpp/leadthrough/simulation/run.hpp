#pragma once

// A whole motion of an arm in simulation, command after command.

#include <functional>

#include "leadthrough/simulation/drives.hpp"

namespace leadthrough::simulation {

// Rows (n, joints): positions and velocities at the samples, and accelerations in the period that
// follows each.
struct Commands {
  const RowsRef &q, &qd, &qdd;
  const VectorRef& progress;  // (n,) fractions of the tip's path
};

// Rows (n, joints), of which only the first `periods` are known. If a joint runs away in the last
// of them, its motion after that and its torques are 0.
struct Record {
  Rows q, qd, qdd;              // at each sample, and the mean acceleration until the next
  Rows torques;                 // behind the gears
  Eigen::VectorXd work, given;  // (joints,) J of the motors, and without what they take up
  // Of what the controller asks of the motors, up to the first touch: the largest fraction of their
  // limits (joints,), and the first sample at which it is above the limits, or kNone.
  Eigen::VectorXd use;
  Eigen::Matrix<Eigen::Index, Eigen::Dynamic, 1> over;
  Eigen::Index periods = 0;
  Eigen::Index runaway = kNone;
};

// The world around the drives.
struct Physics {
  std::function<bool()> step;                 // whether bodies touch in it
  std::function<void(Eigen::Index)> touched;  // hears of each period in whose last step they do
  Eigen::Index periods_after_touch = 0;       // until the motion ends
};

Record run(Drives& drives, const Commands& commands, const Drives::Law& law,
           const Physics& physics);

}  // namespace leadthrough::simulation
