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

// The least sum of distances. Only one row of the table is kept, along the shorter curve.
double least_sum(const Eigen::Ref<const Points>& longer, const Eigen::Ref<const Points>& shorter,
                 Eigen::Index band) {
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
      left = std::min({diagonal, above, left}) + distances[j];
      cost[j] = left;
      diagonal = above;
    }
    for (; before < first; ++before) cost[before] = kInfinity;
  }
  return cost[n - 1];
}

// The least largest distance if it is at most `bound`, else infinity. Of each row of the table only
// the pairs that others within the bound lead to are visited: few, if the curves lie close.
double least_largest_within(double bound, const Eigen::Ref<const Points>& longer,
                            const Eigen::ArrayXXd& columns, Eigen::Index band) {
  constexpr Eigen::Index kAtOnce = 64;  // distances
  const Eigen::Index n = columns.rows(), rows = longer.rows();
  Eigen::ArrayXd distances(n);
  Eigen::ArrayXd cost = Eigen::ArrayXd::Constant(n, kInfinity);
  // The pairs within the bound of the row before lie between these columns.
  Eigen::Index first = 0, last = 0;
  for (Eigen::Index i = 0; i < rows; ++i) {
    check_interrupt();
    const Eigen::Index middle = rows > 1 ? i * (n - 1) / (rows - 1) : 0;
    const Eigen::Index end = n - middle > band ? middle + band + 1 : n;
    Eigen::Index j = middle > band ? std::max(first, middle - band) : first, known = j;
    double diagonal = j > 0 ? cost[j - 1] : i > 0 ? kInfinity : 0.0;
    double left = kInfinity;
    cost.segment(first, j - first).setConstant(kInfinity);
    const Eigen::Index before = last;
    first = n;
    for (; j < end && (j <= before + 1 || left < kInfinity); ++j) {
      if (j == known) {
        const Eigen::Index count = std::min(kAtOnce, n - j);
        distances_to(longer.row(i), columns, j, count, distances);
        known += count;
      }
      const double above = cost[j];
      const double largest = std::max(std::min({diagonal, above, left}), distances[j]);
      left = largest <= bound ? largest : kInfinity;
      cost[j] = left;
      diagonal = above;
      if (left == kInfinity) continue;
      first = std::min(first, j);
      last = j;
    }
    if (first == n) return kInfinity;
  }
  return cost[n - 1];
}

// As soon as a bound, raised step by step, holds, it does not change the result.
double least_largest(const Eigen::Ref<const Points>& longer,
                     const Eigen::Ref<const Points>& shorter, Eigen::Index band) {
  constexpr double kRaised = 4.0;
  const Eigen::ArrayXXd columns = shorter;
  const Eigen::Index n = columns.rows();
  double bound = std::max((longer.row(0) - shorter.row(0)).norm(),
                          (longer.bottomRows<1>() - shorter.bottomRows<1>()).norm());
  if (n > 1)
    bound += (shorter.bottomRows(n - 1) - shorter.topRows(n - 1)).rowwise().norm().maxCoeff();
  for (;; bound *= kRaised) {
    if (!(bound > 0.0)) bound = kInfinity;
    const double found = least_largest_within(bound, longer, columns, band);
    if (found < kInfinity || !(bound < kInfinity)) return found;
  }
}

void check_curves(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b) {
  check_argument(a.rows() > 0 && b.rows() > 0, "a, b: expected at least one point each");
  check_argument(a.cols() == b.cols(), "b: expected points of the dimension of those of a");
}

template <typename Cost>
double cost_of_either(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b,
                      Eigen::Index band, Cost cost) {
  check_curves(a, b);
  check_argument(band > 0, "band: expected at least one row");
  return a.rows() < b.rows() ? cost(b, a, band) : cost(a, b, band);
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
  return cost_of_either(a, b, band, least_sum);
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
  return cost_of_either(a, b, band, least_largest);
}

}  // namespace leadthrough
