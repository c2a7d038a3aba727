#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <tuple>

#include "leadthrough/learn/alignment.hpp"

namespace leadthrough::alignment_tests {

namespace {

Points random_points(int rows, int columns, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  return Points::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

// The definitions, as recursions over the last pair.
double distance(const Points& a, const Points& b, Eigen::Index i, Eigen::Index j) {
  return (a.row(i) - b.row(j)).norm();
}

template <typename Extend>
double recursion(const Points& a, const Points& b, Eigen::Index i, Eigen::Index j, Extend extend) {
  if (i == 0 && j == 0) return distance(a, b, 0, 0);
  double best = INFINITY;
  if (i > 0) best = std::min(best, recursion(a, b, i - 1, j, extend));
  if (j > 0) best = std::min(best, recursion(a, b, i, j - 1, extend));
  if (i > 0 && j > 0) best = std::min(best, recursion(a, b, i - 1, j - 1, extend));
  return extend(best, distance(a, b, i, j));
}

}  // namespace

TEST(Alignment, AgreesWithTheRecursionOnShortCurves) {
  unsigned seed = 0;
  for (const auto& [n, m] : {std::pair(1, 1), {1, 5}, {6, 1}, {4, 6}, {6, 4}, {5, 5}}) {
    for (const int dimension : {1, 2, 3, 7}) {
      const Points a = random_points(n, dimension, ++seed);
      const Points b = random_points(m, dimension, ++seed);
      const auto sum = [](double x, double y) { return x + y; };
      const auto largest = [](double x, double y) { return std::max(x, y); };
      EXPECT_NEAR(dtw_distance(a, b), recursion(a, b, n - 1, m - 1, sum), 1e-13);
      EXPECT_NEAR(frechet_distance(a, b), recursion(a, b, n - 1, m - 1, largest), 1e-15);
    }
  }
}

TEST(Alignment, PathIsMonotoneAndCostsTheDistance) {
  unsigned seed = 50;
  for (const auto& [n, m] : {std::pair(1, 1), {1, 5}, {6, 1}, {14, 36}, {40, 20}}) {
    const Points a = random_points(n, 3, ++seed);
    const Points b = random_points(m, 3, ++seed);
    const Pairs path = dtw_path(a, b);
    EXPECT_EQ(path.row(0), Pairs::Zero(1, 2));
    EXPECT_EQ(path(path.rows() - 1, 0), n - 1);
    EXPECT_EQ(path(path.rows() - 1, 1), m - 1);
    double cost = distance(a, b, 0, 0);
    for (Eigen::Index k = 1; k < path.rows(); ++k) {
      const auto step = (path.row(k) - path.row(k - 1)).eval();
      EXPECT_TRUE(step.minCoeff() >= 0 && step.maxCoeff() == 1);
      cost += distance(a, b, path(k, 0), path(k, 1));
    }
    EXPECT_NEAR(cost, dtw_distance(a, b), 1e-12);
  }
}

TEST(Alignment, IsSymmetricToTheBit) {
  const Points a = random_points(40, 2, 1);
  const Points b = random_points(31, 2, 2);
  EXPECT_EQ(dtw_distance(a, b), dtw_distance(b, a));
  EXPECT_EQ(frechet_distance(a, b), frechet_distance(b, a));
}

TEST(Alignment, OfACurveWithItselfIsZeroEvenWithPauses) {
  const Points a = random_points(10, 3, 3);
  Points paused(20, 3);
  for (int i = 0; i < 20; ++i) paused.row(i) = a.row(i / 2);
  EXPECT_EQ(dtw_distance(a, paused), 0.0);
  EXPECT_EQ(frechet_distance(a, paused), 0.0);
}

TEST(Alignment, FrechetDistanceIsThatOfTheWholeTable) {
  unsigned seed = 90;
  for (const auto& [n, m] : {std::pair(150, 200), {200, 70}, {130, 130}}) {
    for (const double noise : {0.01, 1.0, 30.0}) {
      const Points walk = random_points(n, 3, ++seed);
      Points a(n, 3), b(m, 3);
      a.row(0) = walk.row(0);
      for (int i = 1; i < n; ++i) a.row(i) = a.row(i - 1) + walk.row(i);
      for (int j = 0; j < m; ++j) b.row(j) = a.row(j * (n - 1) / (m - 1));
      b += noise * random_points(m, 3, ++seed);
      for (const Eigen::Index band : {Eigen::Index{3}, Eigen::Index{20}, kWholeTable}) {
        const auto& [rows, columns] = n < m ? std::tie(b, a) : std::tie(a, b);
        const Eigen::Index last = columns.rows() - 1;
        Eigen::MatrixXd table = Eigen::MatrixXd::Constant(rows.rows() + 1, last + 2, INFINITY);
        table(0, 0) = 0.0;
        for (Eigen::Index i = 0; i < rows.rows(); ++i) {
          const Eigen::Index middle = i * last / (rows.rows() - 1);
          for (Eigen::Index j = 0; j <= last; ++j) {
            if (std::abs(j - middle) > band) continue;
            const double before = std::min({table(i, j), table(i, j + 1), table(i + 1, j)});
            table(i + 1, j + 1) = std::max(before, distance(rows, columns, i, j));
          }
        }
        EXPECT_NEAR(frechet_distance(a, b, band), table(rows.rows(), last + 1), 1e-12);
      }
    }
  }
}

}  // namespace leadthrough::alignment_tests
