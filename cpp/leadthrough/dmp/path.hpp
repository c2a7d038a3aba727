#pragma once

// Piecewise quintic paths over the phase: references of transformation systems and offsets of
// orientation curves. Beyond the last break they are constant.

#include "leadthrough/base/matrix.hpp"

namespace leadthrough::dmp {

using Vector = Eigen::VectorXd;

struct Path {
  Vector breaks;      // (pieces + 1), rising; beyond the last one the path rests
  Rows coefficients;  // (6 pieces, channels), of the powers 0 to 5 of u - breaks[piece]

  bool empty() const { return breaks.size() < 2; }
  double end() const { return breaks[breaks.size() - 1]; }
};

// The minimum-jerk path from one value to another, at rest at phases 0 and 1.
Path minimum_jerk(const Vector& from, const Vector& to);

// Phase since the break before it, and the coefficients that hold there.
double place_in_piece(const Path& path, double phase, const double** coefficients);

// The same for consecutive phases, quicker if they increase: each piece is searched from the last
// one on.
class Walk {
 public:
  explicit Walk(const Path& path) : path_(path) {}

  double place_in_piece(double phase, const double** coefficients);
  double end() const { return path_.end(); }

 private:
  const Path& path_;
  Eigen::Index piece_ = 0;
};

// Values at rest, beyond the last break.
Vector end_of(const Path& path);

// A path plus (1 - c) times a shift of its start and c times one of its goal. c is a path with the
// same breaks, given by its coefficients.
Path shifted(Path path, const RowsRef& c, const VectorRef& start, const VectorRef& goal);

// Minimum-jerk addition to a path from a phase on: it begins with a value and a slope, and ends in
// a constant shift.
struct Correction {
  double phase, until;         // phase < until
  Vector value, slope, shift;  // (channels)
};

// The path from the correction's phase on, with the correction. Earlier pieces are dropped, so that
// a path with many corrections stays short.
//
// Superposition of minimum-jerk motions: Flash and Henis 1991, "Arm trajectory modifications during
// reaching towards visual targets", Journal of Cognitive Neuroscience 3.
Path superposed(const Path& path, const Correction& correction);

}  // namespace leadthrough::dmp
