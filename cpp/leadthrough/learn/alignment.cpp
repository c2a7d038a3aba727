#include "leadthrough/learn/alignment.hpp"

#include <algorithm>
#include <vector>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

// Sets part of `distances` to those of one point to rows of the curve, given column by column.
void distances_to(const Eigen::Ref<const Eigen::RowVectorXd>& point, const Eigen::ArrayXXd& columns,
                  Eigen::Index first, Eigen::Index count, Eigen::ArrayXd& distances) {
  auto part = distances.segment(first, count);
  part.setZero();
  for (Eigen::Index k = 0; k < columns.cols(); ++k)
    part += (columns.col(k).segment(first, count) - point[k]).square();
  part = part.sqrt();
}

// Cost of the best pairing, where `extend(best, distance)` is the cost of a pairing of cost `best`
// with one more pair. Only one row of the table is kept, along the shorter curve.
template <typename Extend>
double best_pairing(const Eigen::Ref<const Points>& longer, const Eigen::Ref<const Points>& shorter,
                    Eigen::Index band, Extend extend) {
  const Eigen::ArrayXXd columns = shorter;
  const Eigen::Index n = columns.rows(), rows = longer.rows();
  Eigen::ArrayXd distances(n);
  Eigen::ArrayXd cost = Eigen::ArrayXd::Constant(n, kInfinity);
  for (Eigen::Index i = 0, before = 0; i < rows; ++i) {
    check_interrupt();
    const Eigen::Index middle = rows > 1 ? i * (n - 1) / (rows - 1) : 0;
    const Eigen::Index first = middle > band ? middle - band : 0;
    const Eigen::Index end = n - middle > band ? middle + band + 1 : n;
    distances_to(longer.row(i), columns, first, end - first, distances);
    double diagonal = first > 0 ? cost[first - 1] : i > 0 ? kInfinity : 0.0;
    double left = kInfinity;
    for (Eigen::Index j = first; j < end; ++j) {
      const double above = cost[j];
      const double best = std::min({diagonal, above, left});
      left = extend(best, distances[j]);
      cost[j] = left;
      diagonal = above;
    }
    for (; before < first; ++before) cost[before] = kInfinity;
  }
  return cost[n - 1];
}

void check_curves(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b) {
  check_argument(a.rows() > 0 && b.rows() > 0, "a, b: expected at least one point each");
  check_argument(a.cols() == b.cols(), "b: expected points of the dimension of those of a");
}

template <typename Extend>
double best_pairing_of_either(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b,
                              Eigen::Index band, Extend extend) {
  check_curves(a, b);
  check_argument(band > 0, "band: expected at least one row");
  return a.rows() < b.rows() ? best_pairing(b, a, band, extend) : best_pairing(a, b, band, extend);
}

// The step that leads to a pair.
enum class Move : unsigned char { kAlongBoth, kAlongA, kAlongB };

// The steps that lead to every pair, row by row.
std::vector<Move> best_moves(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b) {
  const Eigen::ArrayXXd columns = b;
  const Eigen::Index n = b.rows();
  std::vector<Move> moves(static_cast<std::size_t>(a.rows() * n));
  Eigen::ArrayXd distances(n);
  Eigen::ArrayXd cost = Eigen::ArrayXd::Constant(n, kInfinity);
  double corner = 0.0;  // the cost before the first pair
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    check_interrupt();
    distances_to(a.row(i), columns, 0, n, distances);
    double diagonal = corner;
    double left = kInfinity;
    Move* row = moves.data() + i * n;
    for (Eigen::Index j = 0; j < n; ++j) {
      const double above = cost[j];
      row[j] = Move::kAlongBoth;
      double best = diagonal;
      if (above < best) {
        row[j] = Move::kAlongA;
        best = above;
      }
      if (left < best) {
        row[j] = Move::kAlongB;
        best = left;
      }
      left = best + distances[j];
      cost[j] = left;
      diagonal = above;
    }
    corner = kInfinity;
  }
  return moves;
}

}  // namespace

double dtw_distance(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b,
                    Eigen::Index band) {
  return best_pairing_of_either(a, b, band,
                                [](double best, double distance) { return best + distance; });
}

Pairs dtw_path(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b) {
  check_curves(a, b);
  const std::vector<Move> moves = best_moves(a, b);
  Pairs pairs(a.rows() + b.rows() - 1, 2);
  Eigen::Index count = 0;
  for (Eigen::Index i = a.rows() - 1, j = b.rows() - 1;;) {
    pairs.row(count++) << static_cast<std::int32_t>(i), static_cast<std::int32_t>(j);
    if (i == 0 && j == 0) break;
    const Move move = moves[static_cast<std::size_t>(i * b.rows() + j)];
    // Costs that overflow leave the path undefined, but all paths end at the first points.
    const bool along_a = j == 0 || (i > 0 && move != Move::kAlongB);
    const bool along_b = i == 0 || (j > 0 && move != Move::kAlongA);
    if (along_a) --i;
    if (along_b) --j;
  }
  return pairs.topRows(count).colwise().reverse();
}

double frechet_distance(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b,
                        Eigen::Index band) {
  return best_pairing_of_either(
      a, b, band, [](double best, double distance) { return std::max(best, distance); });
}

}  // namespace leadthrough
