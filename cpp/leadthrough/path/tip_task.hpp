#pragma once

// The tip's task at one sample of a path, independent of the number of constrained axes.

#include <optional>

#include "leadthrough/ik/any_axes.hpp"

namespace leadthrough::path {

// A path of the tip. orientations: w, x, y, z; no rows leave them free. tube: six rows of six a
// sample, or none: symmetric S such that the tip may be off the sample by e with e' S^-1 e <= 1, m
// along and rad about the axes of the sample's frame; where S is 0 the tip stays. With a tube, axes
// are given.
struct TipPath {
  Rows3Ref positions;
  Rows4Ref orientations;
  std::optional<IkAxes> axes;
  RowsRef tube;
};

// Null-space directions of the joints, orthogonal to each other; the largest element of each
// is 1.
struct FreeDirections {
  int count = 0;
  std::array<JointArray, kMaxJoints> directions{};
};

// Position in the tube, in units of its radii: 0 on the path, of length 1 on the tube's surface.
using TubePlace = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>;

// The task's errors with room in the tube, in m and rad: e = factor * place.
struct Tube {
  std::array<int, 6> rows{};  // of the task's errors
  std::array<int, 6> axes{};  // 0 to 2 along the target's axes, 3 to 5 about them
  Vector6 scale;              // of the task's errors, by which they are weighted
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> factor, inverse;

  int dimension() const { return static_cast<int>(factor.rows()); }
  // Position of an error in the tube, and its change with a joint.
  TubePlace place(const Vector6& error) const;
};

// The task at a sample, which may lie between two rows of the path.
class TipTask {
 public:
  TipTask(const Chain& chain, const TipPath& path, double sample);

  // Moves q onto the task inside the bounds; false if it cannot be met to the tolerance. With a
  // tube, a tip inside does not move, and one outside goes to the nearest position inside.
  bool settle(const JointBox& bounds, const IkTolerance& tolerance, JointArray& q,
              int max_iterations = 12) const;
  // The same onto a position in the tube; an empty one is the path.
  bool settle_at(const TubePlace& place, const JointBox& bounds, const IkTolerance& tolerance,
                 JointArray& q, int max_iterations = 12) const;
  FreeDirections free_directions(const JointArray& q) const;
  void evaluate(const JointArray& q, TipError& error) const;

  const std::optional<Tube>& tube() const { return tube_; }
  // Position of q's tip in the tube; empty without one.
  TubePlace place(const JointArray& q) const;

 private:
  IkTarget moved(const TubePlace& place, const JointArray& q) const;

  const Chain& chain_;
  const std::optional<IkAxes>& axes_;
  IkTarget target_;
  std::optional<Tube> tube_;
};

}  // namespace leadthrough::path
