#pragma once

// What the path asks of the tip at one sample, for searches that need not know how many axes that
// are.

#include <optional>

#include "ik/any_axes.hpp"

namespace leadthrough::path {

// A path of the tip. orientations: w, x, y, z; no rows leave them free.
struct TipPath {
  Eigen::Ref<const Rows3> positions;
  Eigen::Ref<const Rows4> orientations;
  std::optional<IkAxes> axes;
};

// Directions in which the joints move and the tip does not, across each other; the largest element
// of each is 1.
struct FreeDirections {
  int count = 0;
  std::array<JointArray, kMaxJoints> directions{};
};

// The task at a sample, which may lie between two rows of the path.
class TipTask {
 public:
  TipTask(const Chain& chain, const TipPath& path, double sample);

  // Moves q onto the task inside the bounds; false where it cannot be met to the tolerance.
  bool settle(const DescentBounds& bounds, const IkTolerance& tolerance, JointArray& q,
              int max_iterations = 12) const;
  FreeDirections free_directions(const JointArray& q) const;
  void evaluate(const JointArray& q, TipError& error) const;

 private:
  const Chain& chain_;
  const std::optional<IkAxes>& axes_;
  IkTarget target_;
};

}  // namespace leadthrough::path
