#pragma once

// Polytopes about the origin, and their point nearest to a goal by the primal active set method
// (Nocedal and Wright 2006, algorithm 16.3): every iterate lies inside, so it may stop early.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace leadthrough {

// lower <= rows * x <= upper, with lower <= 0 <= upper. Its arguments must outlive it.
template <int kMaxRows, int kMaxColumns>
class Polytope {
 public:
  using Rows =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMaxRows, kMaxColumns>;
  using Sides = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxRows, 1>;
  using Point = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxColumns, 1>;

  Polytope(const Rows& rows, const Sides& lower, const Sides& upper)
      : rows_(rows), lower_(lower), upper_(upper) {}

  bool contains(const Point& x) const {
    for (Eigen::Index i = 0; i < rows_.rows(); ++i) {
      const double value = rows_.row(i).dot(x);
      if (value < lower_[i] || value > upper_[i]) return false;
    }
    return true;
  }

  Point nearest(const Point& goal) {
    Point x = Point::Zero(goal.size());
    const Eigen::Index changes = 8 * (rows_.rows() + 1);  // rounding could make it cycle
    for (Eigen::Index change = 0; change < changes; ++change) {
      const Point away = goal - x;
      const Point direction = along_the_held(away);
      const Blocking next = first_blocking(x, direction);
      x += next.share * direction;
      if (next.row >= 0)
        hold(next.row, next.upper);
      else if (!release_worst(away.norm()))
        break;
    }
    return x;
  }

 private:
  using Square = Eigen::Matrix<double, kMaxColumns, kMaxColumns>;
  struct Held {
    Eigen::Index row;
    bool upper;
  };
  struct Blocking {
    double share = 1.0;
    Eigen::Index row = -1;
    bool upper = false;
  };

  // The part of `away` that leaves the held rows unchanged; also sets their multipliers. By
  // Gram-Schmidt, each projection done twice: the bounds must hold to rounding.
  Point along_the_held(const Point& away) {
    Square triangle;
    for (Eigen::Index i = 0; i < count_; ++i) {
      Point column = row(i).transpose();
      triangle.col(i).setZero();
      for (int again = 0; again < 2; ++again)
        for (Eigen::Index k = 0; k < i; ++k) {
          const double share = span_.col(k).head(away.size()).dot(column);
          triangle(k, i) += share;
          column -= share * span_.col(k).head(away.size());
        }
      triangle(i, i) = column.norm();
      span_.col(i).head(away.size()) = column / triangle(i, i);
    }
    Point direction = away;
    multipliers_.setZero(count_);
    for (int again = 0; again < 2; ++again)
      for (Eigen::Index k = 0; k < count_; ++k) {
        const double share = span_.col(k).head(away.size()).dot(direction);
        multipliers_[k] += share;
        direction -= share * span_.col(k).head(away.size());
      }
    for (Eigen::Index k = count_; k-- > 0;) {
      for (Eigen::Index i = k + 1; i < count_; ++i)
        multipliers_[k] -= triangle(k, i) * multipliers_[i];
      multipliers_[k] /= triangle(k, k);
    }
    if (count_ == away.size()) direction.setZero();
    return direction;
  }

  Blocking first_blocking(const Point& x, const Point& direction) const {
    constexpr double kAlong = 1e-13;  // a fraction of the lengths: lost in rounding
    Blocking first;
    const double length = direction.norm();
    for (Eigen::Index i = 0; i < rows_.rows(); ++i) {
      const double speed = rows_.row(i).dot(direction);
      if (held(i) || !(std::abs(speed) > kAlong * length * rows_.row(i).norm())) continue;
      const double side = speed > 0.0 ? upper_[i] : lower_[i];
      const double share = std::max((side - rows_.row(i).dot(x)) / speed, 0.0);
      if (share < first.share) first = {share, i, speed > 0.0};
    }
    return first;
  }

  void hold(Eigen::Index row, bool upper) {
    working_[static_cast<std::size_t>(count_++)] = {row, upper};
  }

  // Releases the row whose multiplier has the wrong sign by most; false if there is none.
  bool release_worst(double scale) {
    constexpr double kNoise = 1e-13;
    Eigen::Index worst = -1;
    double most = kNoise * scale;
    for (Eigen::Index i = 0; i < count_; ++i) {
      const double outward =
          working_[static_cast<std::size_t>(i)].upper ? multipliers_[i] : -multipliers_[i];
      const double inward = -outward * row(i).norm();
      if (inward <= most) continue;
      most = inward;
      worst = i;
    }
    if (worst < 0) return false;
    working_[static_cast<std::size_t>(worst)] = working_[static_cast<std::size_t>(--count_)];
    return true;
  }

  bool held(Eigen::Index row) const {
    return std::any_of(working_.begin(), working_.begin() + count_,
                       [row](const Held& entry) { return entry.row == row; });
  }

  auto row(Eigen::Index i) const { return rows_.row(working_[static_cast<std::size_t>(i)].row); }

  const Rows& rows_;
  const Sides& lower_;
  const Sides& upper_;
  std::array<Held, kMaxColumns> working_{};
  Eigen::Index count_ = 0;
  Square span_;  // orthonormal columns
  Point multipliers_;
};

}  // namespace leadthrough
