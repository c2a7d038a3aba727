#include "leadthrough/field/path_distance.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

// A path in pieces of consecutive points, each in a bounding ball: pieces whose ball is farther
// than the nearest point so far are skipped.
class Pieces {
 public:
  explicit Pieces(const std::vector<Point>& path) {
    for (std::size_t first = 0; first < path.size(); first += kPoints) {
      Piece piece{};
      for (std::size_t n = 0; n < kPoints; ++n) {
        const Point& p = path[std::min(first + n, path.size() - 1)];
        for (std::size_t axis = 0; axis < 3; ++axis) piece.points[axis][n] = p[axis];
      }
      piece.middle = path[std::min(first + kPoints / 2, path.size() - 1)];
      piece.radius = std::sqrt(farthest(piece)) * (1.0 + kRounding);
      pieces_.push_back(piece);
    }
  }

  // Squared, and not above that of `most`.
  double nearest(const Point& p, double most) {
    double squared = std::min(most * most, nearest_of(pieces_[last_], p));
    double bound = std::sqrt(squared);
    for (std::size_t n = 0; n < pieces_.size(); ++n) {
      const double reach = bound + pieces_[n].radius;
      if (squared_distance(p, pieces_[n].middle) > reach * reach) continue;
      const double here = nearest_of(pieces_[n], p);
      if (here >= squared) continue;
      squared = here;
      bound = std::sqrt(here);
      last_ = n;
    }
    return squared;
  }

 private:
  static constexpr std::size_t kPoints = 16;
  static constexpr double kRounding = 1e-12;  // more than distances are rounded by

  struct Piece {
    Point middle;
    double radius;
    std::array<std::array<double, kPoints>, 3> points;  // axis by axis
  };

  static double squared_distance(const Point& a, const Point& b) {
    const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + y * y + z * z;
  }

  static std::array<double, kPoints> squares(const Piece& piece, const Point& p) {
    std::array<double, kPoints> result;
    for (std::size_t n = 0; n < kPoints; ++n) {
      const double x = p[0] - piece.points[0][n], y = p[1] - piece.points[1][n],
                   z = p[2] - piece.points[2][n];
      result[n] = x * x + y * y + z * z;
    }
    return result;
  }

  static double nearest_of(const Piece& piece, const Point& p) {
    std::array<double, kPoints> least = squares(piece, p);
    for (std::size_t half = kPoints / 2; half > 0; half /= 2)
      for (std::size_t n = 0; n < half; ++n) least[n] = std::min(least[n], least[n + half]);
    return least[0];
  }

  static double farthest(const Piece& piece) {
    const std::array<double, kPoints> all = squares(piece, piece.middle);
    return *std::max_element(all.begin(), all.end());
  }

  std::vector<Piece> pieces_;
  std::size_t last_ = 0;  // the nearest piece of the previous query
};

}  // namespace

std::vector<double> path_distances(const std::vector<Point>& points, const std::vector<Point>& path,
                                   double most) {
  Pieces pieces(path);
  std::vector<double> result(points.size());
  for (std::size_t n = 0; n < points.size(); ++n) {
    check_interrupt(n);
    result[n] = std::sqrt(pieces.nearest(points[n], most));
  }
  return result;
}

}  // namespace leadthrough
