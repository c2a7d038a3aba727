#include "leadthrough/dmp/path.hpp"

#include <algorithm>
#include <vector>

#include "leadthrough/base/argument.hpp"

namespace leadthrough::dmp {

namespace {

// Breaks nearer than this to each other count as equal: rounding.
constexpr double kSameBreak = 1e-12;

using Piece = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>;

// The same polynomial about a point shifted by `by`: Horner's scheme, once for each power.
void move_on(Piece& piece, double by) {
  for (Eigen::Index first = 0; first < 5; ++first)
    for (Eigen::Index power = 4; power >= first; --power)
      piece.row(power) += by * piece.row(power + 1);
}

// The path's polynomial from one break to the next, about the first. It is looked up at the middle,
// because breaks of two paths may differ by rounding.
Piece taken_between(const Path& path, double from, double to) {
  const double middle = 0.5 * (from + to);
  if (middle >= path.end()) {
    Piece rest = Piece::Zero(6, path.coefficients.cols());
    rest.row(0) = end_of(path).transpose();
    return rest;
  }
  const double* coefficients = nullptr;
  const double since = place_in_piece(path, middle, &coefficients);
  Piece result = Eigen::Map<const Piece>(coefficients, 6, path.coefficients.cols());
  move_on(result, since - (middle - from));
  return result;
}

Path quintic(const Correction& c) {
  const double length = c.until - c.phase;
  const Vector d = c.shift - c.value;
  const Vector rise = length * c.slope;
  Path result{Vector(2), Rows::Zero(6, d.size())};
  result.breaks << c.phase, c.until;
  result.coefficients.row(0) = c.value.transpose();
  result.coefficients.row(1) = c.slope.transpose();
  double scale = length * length * length;
  result.coefficients.row(3) = (10.0 * d - 6.0 * rise).transpose() / scale;
  scale *= length;
  result.coefficients.row(4) = (8.0 * rise - 15.0 * d).transpose() / scale;
  scale *= length;
  result.coefficients.row(5) = (6.0 * d - 3.0 * rise).transpose() / scale;
  return result;
}

// Breaks of the path after the correction's phase, and of the correction, in order.
std::vector<double> joined_breaks(const Path& path, const Correction& correction) {
  std::vector<double> result{correction.phase, correction.until};
  for (const double at : path.breaks)
    if (at > correction.phase + kSameBreak) result.push_back(at);
  std::sort(result.begin(), result.end());
  const auto same = [](double left, double right) { return right - left < kSameBreak; };
  result.erase(std::unique(result.begin(), result.end(), same), result.end());
  return result;
}

}  // namespace

Path minimum_jerk(const Vector& from, const Vector& to) {
  Path result{Vector(2), Rows::Zero(6, from.size())};
  result.breaks << 0.0, 1.0;
  const Vector displacement = to - from;
  result.coefficients.row(0) = from.transpose();
  result.coefficients.row(3) = 10.0 * displacement.transpose();
  result.coefficients.row(4) = -15.0 * displacement.transpose();
  result.coefficients.row(5) = 6.0 * displacement.transpose();
  return result;
}

double place_in_piece(const Path& path, double phase, const double** coefficients) {
  const double* first = path.breaks.data() + 1;
  const Eigen::Index pieces = path.breaks.size() - 1;
  const Eigen::Index piece = std::upper_bound(first, first + pieces - 1, phase) - first;
  *coefficients = path.coefficients.data() + 6 * piece * path.coefficients.cols();
  return std::min(phase, path.breaks[pieces]) - path.breaks[piece];
}

double Walk::place_in_piece(double phase, const double** coefficients) {
  const Eigen::Index last = path_.breaks.size() - 2;
  if (!(phase >= path_.breaks[piece_])) piece_ = 0;
  while (piece_ < last && path_.breaks[piece_ + 1] <= phase) ++piece_;
  *coefficients = path_.coefficients.data() + 6 * piece_ * path_.coefficients.cols();
  return std::min(phase, path_.end()) - path_.breaks[piece_];
}

Vector end_of(const Path& path) {
  const Eigen::Index last = path.breaks.size() - 2;
  const double length = path.breaks[last + 1] - path.breaks[last];
  Vector result = path.coefficients.row(6 * last + 5);
  for (Eigen::Index power = 4; power >= 0; --power)
    result = (result * length + path.coefficients.row(6 * last + power).transpose()).eval();
  return result;
}

Path shifted(Path path, const RowsRef& c, const VectorRef& start, const VectorRef& goal) {
  const Eigen::Index channels = path.coefficients.cols();
  check_argument(c.rows() == path.coefficients.rows() && c.cols() == channels,
                 "c: expected the pieces of the path");
  check_argument(start.size() == channels && goal.size() == channels,
                 "start, goal: expected one value a channel");
  const Eigen::RowVectorXd displacement = (goal - start).transpose();
  for (Eigen::Index i = 0; i < c.rows(); ++i) {
    const auto shift = c.row(i).cwiseProduct(displacement);
    if (i % 6 == 0)
      path.coefficients.row(i) += shift + start.transpose();
    else
      path.coefficients.row(i) += shift;
  }
  return path;
}

Path superposed(const Path& path, const Correction& correction) {
  const auto channels = correction.shift.size();
  check_argument(correction.phase < correction.until, "until: expected a later phase");
  check_argument(correction.value.size() == channels && correction.slope.size() == channels &&
                     (path.empty() || path.coefficients.cols() == channels),
                 "correction: expected one value a channel");
  const std::vector<double> breaks = joined_breaks(path, correction);
  const auto pieces = static_cast<Eigen::Index>(breaks.size()) - 1;
  const Path added = quintic(correction);
  Path result{Vector(pieces + 1), Rows(6 * pieces, correction.value.size())};
  for (Eigen::Index i = 0; i <= pieces; ++i) result.breaks[i] = breaks[static_cast<std::size_t>(i)];
  for (Eigen::Index i = 0; i < pieces; ++i) {
    auto piece = result.coefficients.middleRows(6 * i, 6);
    const double from = result.breaks[i];
    const double to = result.breaks[i + 1];
    piece = taken_between(added, from, to);
    if (!path.empty()) piece += taken_between(path, from, to);
  }
  return result;
}

}  // namespace leadthrough::dmp
