#include "leadthrough/alignment.hpp"

#include <algorithm>

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

}  // namespace

double dtw_distance(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b) {
  return best_pairing_of_either(a, b, [](double best, double distance) { return best + distance; });
}

double frechet_distance(const Eigen::Ref<const Points>& a, const Eigen::Ref<const Points>& b) {
  return best_pairing_of_either(
      a, b, [](double best, double distance) { return std::max(best, distance); });
}

}  // namespace leadthrough
