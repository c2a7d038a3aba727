#pragma once

// A target may leave angles of the closed form free, as beside a singular wrist: the connected
// sets of configurations inside the limits, each by its member nearest to a reference.

#include <vector>

#include "leadthrough/ik/closed_form.hpp"

namespace leadthrough {

// Of the sets with `free` free angles, 1 or 2. `walk` holds the slack.
std::vector<JointArray> nearest_members(const Chain& chain, const ClosedForm& form,
                                        const IkTarget& target, const JointVector& reference,
                                        const Walk& walk, int free);

}  // namespace leadthrough
