#include "leadthrough/learn/alignment.hpp"

#include <algorithm>
#include <vector>

#include "leadthrough/base/constants.hpp"

namespace leadthrough {

namespace {

// Fills `distances` with those of one point to every row of the curve, given column by column.
void distances_to(const Eigen::Ref<const Eigen::RowVectorXd>& point, const Eigen::ArrayXXd& columns,
                  Eigen::ArrayXd& distances) {
  distances.setZero();
  for (Eigen::Index k = 0; k < columns.cols(); ++k)
    distances += (columns.col(k) - point[k]).square();
  distances = distances.sqrt();
}

// Cost of the best pairing, where `extend(best, distance)` is the cost of a pairing of cost `best`
// with one more pair. Only one row of the table is kept, along the shorter curve.
template <typename Extend>
double best_pairing(const Eigen::Ref<const Points>& longer, const Eigen::Ref<const Points>& shorter,
                    Extend extend) {
  const Eigen::ArrayXXd columns = shorter;
  const Eigen::Index n = columns.rows();
  Eigen::ArrayXd distances(n);
  Eigen::ArrayXd cost(n);

  distances_to(longer.row(0), columns, distances);
  cost[0] = distances[0];
  for (Eigen::Index j = 1; j < n; ++j) cost[j] = extend(cost[j - 1], distances[j]);

  for (Eigen::Index i = 1; i < longer.rows(); ++i) {
    distances_to(longer.row(i), columns, distances);
    double diagonal = cost[0];
    cost[0] = extend(cost[0], distances[0]);
    for (Eigen::Index j = 1; j < n; ++j) {
      const double above = cost[j];
      cost[j] = extend(std::min({diagonal, above, cost[j - 1]}), distances[j]);
      diagonal = above;
    }
  }
  return cost[n - 1];
}

template <typename Extend>
double best_pairing_of_either(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b,
                              Extend extend) {
  return a.rows() < b.rows() ? best_pairing(b, a, extend) : best_pairing(a, b, extend);
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
    distances_to(a.row(i), columns, distances);
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

double dtw_distance(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b) {
  return best_pairing_of_either(a, b, [](double best, double distance) { return best + distance; });
}

Pairs dtw_path(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b) {
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

double frechet_distance(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b) {
  return best_pairing_of_either(
      a, b, [](double best, double distance) { return std::max(best, distance); });
}

}  // namespace leadthrough
