#pragma once

// The gate before an arm, as `lt.Guard`, but for chunks that have to be changed: they are refused.

#include <vector>

#include "leadthrough/arm.hpp"
#include "leadthrough/guard/contact.hpp"

namespace leadthrough {

// Margins, m.
struct GuardMargins {
  double obstacles = 0.005, itself = 0.0;
};

// The commands still to come are always a motion that ends at rest, inside all limits and clear of
// everything between samples too. So if nothing is admitted any more, the arm follows what was, and
// stops. For one thread at a time.
class Guard {
 public:
  using Joints = VectorRef;

  // limits: of the arm's joints, with the period of the commands. obstacles: they stand still.
  // Throws std::invalid_argument for limits that are not known, and so do the members for arguments
  // of a wrong size.
  Guard(const Arm& arm, guard::StepLimits limits, const std::vector<Shape>& obstacles = {},
        const GuardMargins& margins = {});

  // The arm rests at these joints and is commanded to them; nothing is left to come.
  void start(const Joints& q);

  // Admits positions (n, joints), the first of which is due one period from now: they and the
  // fastest stop after them replace all commands to come. False, and the commands stay, if that
  // exceeds a limit or comes too near something. It allocates memory.
  bool admit(const Arm::Path& positions);

  // Goes on by one period; after the last command the arm rests. It allocates nothing.
  void next();

  // Commanded now: rad (m), per second and per second squared.
  auto q() const { return part(0); }
  auto qd() const { return part(1); }
  auto qdd() const { return part(2); }
  Eigen::Index remaining() const { return stream_.rows() - 1 - at_; }  // commands until rest

 private:
  Eigen::Map<const Eigen::VectorXd> part(Eigen::Index order) const {
    const Eigen::Index joints = limits_.joints();
    return {stream_.data() + (3 * at_ + order) * joints, joints};
  }

  guard::StepLimits limits_;
  guard::GuardedScene scene_;
  Rows stream_;  // states (n, 3 joints); `at_` is the row that is commanded now
  Eigen::Index at_ = 0;
};

}  // namespace leadthrough
