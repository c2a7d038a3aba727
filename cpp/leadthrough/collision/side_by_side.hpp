#pragma once

// Two arms as one: the joints of the left arm, then those of the right arm.

#include "leadthrough/collision/check.hpp"

namespace leadthrough {

struct ArmPlacement {
  Transform T_left_right;      // of the bases
  bool one_robot = false;      // both arms are parts of one robot, with the same base
  bool shared_object = false;  // the right arm holds what is attached to the left one as well
};

// The right arm stands at the base as the left one does, so the end of this chain is no tip. names:
// of the joints of both. Throws std::invalid_argument above kMaxJoints.
Chain side_by_side(const Chain& left, const Chain& right, const Transform& T_left_right,
                   const std::vector<std::string>& names);

// Names of the bodies of two robots begin with "left_" and "right_". Pairs of one arm are those of
// its model. Between the arms all pairs are checked that can come within `margin`, m, but not a
// shared object and the hand that holds it.
CollisionModel side_by_side(const CollisionModel& left, const CollisionModel& right,
                            const ArmPlacement& placement, const std::vector<std::string>& names,
                            double margin = 0.05);

}  // namespace leadthrough
