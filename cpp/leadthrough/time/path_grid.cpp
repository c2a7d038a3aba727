#include "leadthrough/time/path_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

// The parameter's own pace counts as much as the mean motion: small enough to close gaps, large
// enough to keep the new parameter smooth where the motion stops and turns.
constexpr double kOwnPace = 1.0;
constexpr Index kMinPointsAPiece = 4;
// More pieces than a quarter of so many, one a sample of minutes, have fewer points each.
constexpr Index kMostInPieces = 1'000'000;
// Share of the points that is spread over the turns.
constexpr double kShareOfTurns = 1.0 / 3.0;

// A cell is halved that is so many times wider than one beside it.
constexpr double kWider = 4.0;
constexpr int kMaxHalvings = 64;
// Parameters nearer to each other than this share of the largest are the same.
constexpr double kTwins = 1e-14;

// Gauss and Legendre's three points on [0, 1].
constexpr std::array<double, 3> kGaussPoint{0.1127016653792583, 0.5, 0.8872983346207417};
constexpr std::array<double, 3> kGaussWeight{5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};

// The pace: by how much the length grows with s.
class Pace {
 public:
  Pace(const PolynomialPath& path, const VectorRef& scale)
      : path_(path),
        weight_(scale.size()),
        q_(scale.size()),
        first_(scale.size()),
        second_(scale.size()) {
    for (Index j = 0; j < scale.size(); ++j)
      weight_[j] = scale[j] > 0.0 ? 1.0 / (scale[j] * scale[j]) : 0.0;
  }

  void move_to(double s) {
    piece_ = path_.piece_of(s, piece_);
    path_.position(s, piece_, q_.data(), first_.data(), second_.data());
    speed_ = weight_.dot(first_.cwiseAbs2());
    bend_ = weight_.dot(first_.cwiseProduct(second_));
    value_ = std::sqrt(speed_ + least_ * least_);
  }

  double value() const { return value_; }
  double speed() const { return std::sqrt(speed_); }
  double slope() const { return bend_ / value_; }
  // By how much the direction of motion turns with s, in rad, in the scaled space.
  double turn() const {
    const double squared = weight_.dot(second_.cwiseAbs2()) - slope() * slope();
    return std::sqrt(std::max(squared, 0.0)) / value_;
  }
  void set_least(double least) { least_ = least; }
  const VectorXd& q() const { return q_; }
  const VectorXd& first() const { return first_; }
  const VectorXd& second() const { return second_; }

  double integral(double from, double to) {
    double sum = 0.0;
    for (std::size_t k = 0; k < kGaussPoint.size(); ++k) {
      move_to(from + kGaussPoint[k] * (to - from));
      sum += kGaussWeight[k] * value_;
    }
    return sum * (to - from);
  }

 private:
  const PolynomialPath& path_;
  VectorXd weight_, q_, first_, second_;
  Index piece_ = 0;
  double least_ = 0.0, speed_ = 0.0, bend_ = 0.0, value_ = 0.0;
};

Index least_in_a_piece(const PolynomialPath& path) {
  return std::clamp<Index>(kMostInPieces / path.pieces(), 1, kMinPointsAPiece);
}

// The middles of equal parts of every piece, with their widths.
struct Parts {
  VectorXd middle, width;
};

Parts parts(const PolynomialPath& path, Index points) {
  const Index each = std::max(least_in_a_piece(path), points / path.pieces());
  Parts result{VectorXd(each * path.pieces()), VectorXd(each * path.pieces())};
  for (Index p = 0; p < path.pieces(); ++p) {
    const double width = (path.breaks[p + 1] - path.breaks[p]) / static_cast<double>(each);
    for (Index k = 0; k < each; ++k) {
      result.middle[p * each + k] = path.breaks[p] + (static_cast<double>(k) + 0.5) * width;
      result.width[p * each + k] = width;
    }
  }
  return result;
}

// Values of s that part the path equally by length and turns; tells `pace` the mean motion.
VectorXd spread(const PolynomialPath& path, Pace& pace, Index points) {
  const Parts part = parts(path, points);
  const Index count = part.middle.size();
  double motion = 0.0;
  for (Index k = 0; k < count; ++k) {
    pace.move_to(part.middle[k]);
    motion += pace.speed() * part.width[k];
  }
  const double span = path.breaks[path.pieces()] - path.breaks[0];
  pace.set_least(kOwnPace * motion / span);

  VectorXd length(count), turn(count);
  for (Index k = 0; k < count; ++k) {
    pace.move_to(part.middle[k]);
    length[k] = pace.value() * part.width[k];
    turn[k] = pace.turn() * part.width[k];
  }
  const double turns = turn.sum();
  const double weight = turns > 0.0 ? kShareOfTurns * length.sum() / turns : 0.0;
  const VectorXd density = length + weight * turn;
  const double step = density.sum() / static_cast<double>(points - 1);

  VectorXd s(points);
  Index part_index = 0;
  double before = 0.0;
  for (Index i = 0; i < points; ++i) {
    const double wanted = step * static_cast<double>(i);
    while (part_index + 1 < count && before + density[part_index] < wanted)
      before += density[part_index++];
    const double within = std::clamp((wanted - before) / density[part_index], 0.0, 1.0);
    s[i] = part.middle[part_index] + (within - 0.5) * part.width[part_index];
  }
  s[0] = path.breaks[0];
  s[points - 1] = path.breaks[path.pieces()];
  return s;
}

// With some more points, and those at the ends of pieces that cells are too wide for, and inside.
std::vector<double> with_short_pieces(const PolynomialPath& path, const VectorXd& s,
                                      std::vector<double> result) {
  result.insert(result.end(), s.data(), s.data() + s.size());
  const Index each = least_in_a_piece(path);
  for (Index p = 0, i = 0; p < path.pieces(); ++p) {
    const double first = path.breaks[p], width = path.breaks[p + 1] - first;
    while (i + 2 < s.size() && s[i + 1] <= first) ++i;
    if (s[i + 1] - s[i] <= width / static_cast<double>(each)) continue;
    for (Index k = 0; k <= each; ++k)
      result.push_back(first + width * static_cast<double>(k) / static_cast<double>(each));
  }
  std::sort(result.begin(), result.end());
  const double least = kTwins * std::max(std::abs(result.front()), std::abs(result.back()));
  std::vector<double> apart{result.front()};
  for (const double value : result)
    if (value > apart.back() + least) apart.push_back(value);
  if (apart.size() < 3) return {s.data(), s.data() + s.size()};  // no numbers
  apart.back() = result.back();
  return apart;
}

// Halves cells until none is much wider than its neighbours: what is held back beside a narrow
// turn is held back on so many cells, however wide they are.
VectorXd graded(std::vector<double> s) {
  bool again = true;
  for (int pass = 0; again && pass < kMaxHalvings; ++pass) {
    check_interrupt();
    again = false;
    std::vector<double> finer{s.front()};
    for (std::size_t i = 0; i + 1 < s.size(); ++i) {
      const double width = s[i + 1] - s[i];
      const bool wide = (i > 0 && width > kWider * (s[i] - s[i - 1])) ||
                        (i + 2 < s.size() && width > kWider * (s[i + 2] - s[i + 1]));
      if (wide) finer.push_back(s[i] + 0.5 * width);
      finer.push_back(s[i + 1]);
      again = again || wide;
    }
    s.swap(finer);
  }
  return Eigen::Map<VectorXd>(s.data(), static_cast<Index>(s.size()));
}

}  // namespace

PathGrid make_path_grid(const PolynomialPath& path, const VectorRef& scale, Index points,
                        const std::vector<double>& also) {
  const Index pieces = path.pieces();
  check_argument(pieces > 0 && path.coefficients.rows() >= pieces &&
                     path.coefficients.rows() % pieces == 0 && path.joints() > 0,
                 "path: expected as many rows of coefficients for each piece");
  check_argument(scale.size() == path.joints(), "scale: expected one value a joint");
  check_argument(points > 2 && points <= kMaxGridPoints, "points: expected 3 to kMaxGridPoints");
  for (const double s : also)
    check_argument(s > path.breaks[0] && s < path.breaks[pieces],
                   "also: expected parameters inside the path");
  Pace pace(path, scale);
  PathGrid grid;
  grid.scale = scale;
  grid.s = graded(with_short_pieces(path, spread(path, pace, points), also));
  points = grid.s.size();
  grid.length.resize(points);
  grid.slope.resize(points);
  grid.bend.resize(points);
  for (Rows* rows : {&grid.positions, &grid.first, &grid.second})
    rows->resize(points, path.joints());
  grid.length[0] = 0.0;
  for (Index i = 0; i < points; ++i) {
    check_interrupt(i);
    if (i > 0) grid.length[i] = grid.length[i - 1] + pace.integral(grid.s[i - 1], grid.s[i]);
    pace.move_to(grid.s[i]);
    const double slope = 1.0 / pace.value();
    const double bend = -pace.slope() * slope * slope * slope;
    grid.slope[i] = slope;
    grid.bend[i] = bend;
    grid.positions.row(i) = pace.q();
    grid.first.row(i) = pace.first() * slope;
    grid.second.row(i) = pace.second() * (slope * slope) + pace.first() * bend;
  }
  return grid;
}

CellParameter::Values CellParameter::at(const PathGrid& grid, double length) {
  const Index last = grid.points() - 1;
  for (const Index end : {Index{0}, last}) {
    if (end == 0 ? length > 0.0 : length < grid.length[last]) continue;
    const double beyond = length - grid.length[end];
    return {grid.s[end] + beyond * grid.slope[end], grid.slope[end],
            beyond == 0.0 ? grid.bend[end] : 0.0};
  }
  while (cell_ > 0 && length < grid.length[cell_]) --cell_;
  while (cell_ + 1 < last && length >= grid.length[cell_ + 1]) ++cell_;
  if (cell_ != entered_) enter(grid, cell_);
  const auto& [s, v0, a0, c3, c4, c5] = terms_;
  const double t = (length - grid.length[cell_]) * per_width_;
  return {
      s + t * (v0 + t * (a0 + t * (c3 + t * (c4 + t * c5)))),
      (v0 + t * (2.0 * a0 + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5)))) * per_width_,
      (2.0 * a0 + t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5))) * (per_width_ * per_width_)};
}

void CellParameter::enter(const PathGrid& grid, Index cell) {
  const double h = grid.length[cell + 1] - grid.length[cell];
  const double v0 = h * grid.slope[cell], v1 = h * grid.slope[cell + 1];
  const double a0 = 0.5 * h * h * grid.bend[cell], a1 = 0.5 * h * h * grid.bend[cell + 1];
  const double rise = grid.s[cell + 1] - grid.s[cell] - v0 - a0;
  const double speed = v1 - v0 - 2.0 * a0, half = a1 - a0;
  terms_ = {grid.s[cell],
            v0,
            a0,
            10.0 * rise - 4.0 * speed + half,
            -15.0 * rise + 7.0 * speed - 2.0 * half,
            6.0 * rise - 3.0 * speed + half};
  per_width_ = 1.0 / h;
  entered_ = cell;
}

PathStates::PathStates(const PolynomialPath& path, const PathGrid& grid)
    : path_(path),
      grid_(grid),
      position_(path.joints()),
      velocity_(path.joints()),
      acceleration_(path.joints()) {}

void PathStates::move_to(double length, double speed, double push) {
  const CellParameter::Values at = parameter_.at(grid_, length);
  piece_ = path_.piece_of(at.s, piece_);
  path_.position(at.s, piece_, position_.data(), velocity_.data(), acceleration_.data());
  const double pace = at.slope * speed, change = at.bend * speed * speed + at.slope * push;
  for (Index j = 0; j < path_.joints(); ++j) {
    acceleration_[j] = acceleration_[j] * (pace * pace) + velocity_[j] * change;
    velocity_[j] *= pace;
  }
}

}  // namespace leadthrough
