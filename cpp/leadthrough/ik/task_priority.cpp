#include "leadthrough/ik/task_priority.hpp"

#include <algorithm>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/ik/priority_pass.hpp"

namespace leadthrough {

namespace {

JointVector forward(std::vector<Level>& levels, const MotionBox& box, double quickness) {
  PriorityPass pass(box, quickness);
  for (Level& level : levels) {
    if (!(level.activation > 0.0)) continue;
    const double less = level.relief * (1.0 / level.activation - 1.0);
    level.bounded = level.unilateral ? pass.at_least(level.jacobian, level.wanted[0] - less)
                                     : pass.equal(level.jacobian, level.wanted);
  }
  return pass.motion();
}

// The pass that aims at the demands of the levels from `top` to `held` and preserves the effect of
// `motion` on the levels from `held` on.
JointVector correct(std::vector<Level>& levels, std::size_t top, std::size_t held,
                    const JointVector& motion, const MotionBox& box, double quickness) {
  PriorityPass pass(box, quickness);
  for (std::size_t i = top; i < levels.size(); ++i) {
    Level& level = levels[i];
    if (!(level.activation > 0.0)) continue;
    JointVector wanted = level.wanted;
    if (i >= held) {
      const JointVector done = level.jacobian.lazyProduct(motion);
      wanted = level.unilateral ? done.cwiseMin(level.wanted).eval() : done;
    }
    const bool bounded = level.unilateral ? pass.at_least(level.jacobian, wanted[0])
                                          : pass.equal(level.jacobian, wanted);
    level.bounded = level.bounded || bounded;
  }
  return pass.motion();
}

// Consecutive levels that are fully active are taken in one pass: the same as one by one.
bool begins_a_pass(const std::vector<Level>& levels, std::size_t i) {
  if (levels[i].activation < 1.0) return true;
  while (i > 0)
    if (levels[--i].activation > 0.0) return levels[i].activation < 1.0;
  return true;
}

JointVector reverse(std::vector<Level>& levels, const MotionBox& box, double quickness) {
  JointVector motion = PriorityPass(box, quickness).motion();
  std::size_t held = levels.size();
  for (std::size_t i = levels.size(); i-- > 0;) {
    const double share = levels[i].activation;
    if (!(share > 0.0) || !begins_a_pass(levels, i)) continue;
    motion += share * (correct(levels, i, held, motion, box, quickness) - motion);
    held = i;
  }
  return motion.cwiseMax(box.lower).cwiseMin(box.upper);
}

}  // namespace

JointVector resolve(std::vector<Level>& levels, const MotionBox& box, PriorityScheme scheme,
                    double quickness) {
  check_argument((box.lower.array() <= box.upper.array()).all(),
                 "box: expected lower bounds up to the upper ones");
  for (Level& level : levels) level.bounded = false;
  return scheme == PriorityScheme::kForward ? forward(levels, box, quickness)
                                            : reverse(levels, box, quickness);
}

}  // namespace leadthrough
