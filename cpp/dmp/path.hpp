#pragma once

// Quintics in a row, by the phase: what springs follow, and what turns a curve. Beyond their last
// break they rest.

#include "base/matrix.hpp"

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

// The same for one phase after the other, quicker where they rise: each piece is looked for from
// the last one on.
class Walk {
 public:
  explicit Walk(const Path& path) : path_(path) {}

  double place_in_piece(double phase, const double** coefficients);
  double end() const { return path_.end(); }

 private:
  const Path& path_;
  Eigen::Index piece_ = 0;
};

// Values where the path rests.
Vector end_of(const Path& path);

// A path plus (1 - c) times a shift of its start and c times one of its goal. c is a path with the
// same breaks, of which the coefficients are given.
Path shifted(Path path, const Eigen::Ref<const Rows>& c, const Eigen::Ref<const Vector>& start,
             const Eigen::Ref<const Vector>& goal);

// Minimum-jerk addition to a path from a phase on: it begins with a value and a slope, and ends in
// a shift that stays.
struct Correction {
  double phase, until;         // phase < until
  Vector value, slope, shift;  // (channels)
};

// The path from the correction's phase on, with the correction. What lies before is forgotten, so
// that a path that is corrected again and again stays short.
//
// Superposition of minimum-jerk motions: Flash and Henis 1991, "Arm trajectory modifications during
// reaching towards visual targets", Journal of Cognitive Neuroscience 3.
Path superposed(const Path& path, const Correction& correction);

}  // namespace leadthrough::dmp
