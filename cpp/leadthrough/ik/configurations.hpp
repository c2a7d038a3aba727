#pragma once

// All configurations of a six-joint arm for a pose, inside its limits: the closed form's, moved
// onto the real arm, with the whole turns nearest to a reference. If the target leaves an angle
// free, each connected set of configurations has its member nearest to the reference.

#include <vector>

#include "leadthrough/ik/closed_form.hpp"
#include "leadthrough/ik/solve.hpp"

namespace leadthrough {

struct Configurations {
  std::vector<IkResult> found;  // nearest to the reference first
  // Of no configuration: beyond the arm, or outside its limits, those of `limiting`.
  IkStatus status = IkStatus::kUnreachable;
  std::array<bool, kMaxJoints> limiting{};
  // The arm deviates from its structure and the pose is near a singularity: some may be missing.
  bool uncertain = false;
};

// Whether a closed form, or null, enumerates such targets: whole poses, all axes alike.
bool applies(const ClosedForm* form, const IkTarget& target, const IkOptions& options);

// The target has a rotation, and `form` no parameter.
Configurations all_configurations(const Chain& chain, const ClosedForm& form,
                                  const IkTarget& target, const JointVector& reference,
                                  const IkTolerance& tolerance);

// Outside of its limits by so little, rad, a configuration may have one inside that reaches the
// pose as well.
constexpr double kBesideLimit = 1e-6;

// Joints that no whole turn brings inside their limits, and those that the nearest limit moved by
// less than rounding beside a singularity does.
struct Turns {
  std::array<bool, kMaxJoints> outside{}, clamped{};
  bool any_outside = false;
};

// Moves each angle by whole turns to the nearest to a reference inside the limits.
Turns take_turns(const Chain& chain, const JointVector& reference, JointArray& q);

// So too, and puts joints that have none at the nearer limit; returns the largest such change, rad.
double bring_inside(const Chain& chain, const JointVector& reference, JointArray& q);

}  // namespace leadthrough
