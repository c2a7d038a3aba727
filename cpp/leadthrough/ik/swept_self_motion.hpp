#pragma once

// Configurations of a seven-joint arm for a pose: the closed form at evenly spaced values of its
// parameter, and from the nearest to a reference on each branch a descent along the self-motion.

#include "leadthrough/ik/configurations.hpp"

namespace leadthrough {

// Values of the parameter over its range.
constexpr int kSweepSamples = 192;

// Distance of these, rad.
double sweep_resolution(const Chain& chain, const ClosedForm& form);

// Whether a closed form, or null, is swept for such targets: whole poses, all axes alike.
bool sweeps(const ClosedForm* form, const IkTarget& target, const IkOptions& options);

// Nearest to the reference first. The `count` nearest of the sweep are moved along the self-motion;
// uncertain if that fails for all, as beside a singularity.
Configurations swept_configurations(const Chain& chain, const ClosedForm& form,
                                    const IkTarget& target, const JointVector& reference,
                                    const IkTolerance& tolerance, int count);

}  // namespace leadthrough
