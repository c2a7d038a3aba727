#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "leadthrough/learn/curves.hpp"

namespace leadthrough::curves_tests {

namespace {

struct Filled {
  std::vector<Rows> curves;
  bool certain;
};

// Two bases below each other, of as many rows each.
Filled filled(const Rows& bases, const Rows& weights, Eigen::Index curves, int threads) {
  const Eigen::Index rows = bases.rows() / 2;
  const auto some = [&](Eigen::Index first, Eigen::Index count) {
    Rows result(2 * count, bases.cols());
    result << bases.middleRows(first, count), bases.middleRows(rows + first, count);
    return result;
  };
  std::vector<Rows> result(static_cast<std::size_t>(weights.rows()), Rows(bases.rows(), curves));
  std::vector<double*> places;
  for (Rows& each : result) places.push_back(each.data());
  const bool certain = fill_curves(some, rows, weights, curves, threads, places);
  return {std::move(result), certain};
}

}  // namespace

TEST(Curves, AreProductsOfFunctionsAndWeights) {
  for (const Eigen::Index rows : {1, 2, 63, 64, 201})
    for (const Eigen::Index curves : {1, 2, 3, 4, 7, 9}) {
      const Rows bases = Rows::Random(2 * rows, 6);
      const Rows weights = Rows::Random(5, 6 * curves);
      const Filled found = filled(bases, weights, curves, 1);
      EXPECT_TRUE(found.certain);
      for (Eigen::Index i = 0; i < weights.rows(); ++i) {
        const Eigen::Map<const Rows> own(weights.row(i).data(), curves, 6);
        const Rows wanted = bases * own.transpose();
        EXPECT_LT((found.curves[static_cast<std::size_t>(i)] - wanted).cwiseAbs().maxCoeff(),
                  1e-14);
      }
    }
}

TEST(Curves, AreTheSameOnAnyNumberOfThreads) {
  const Rows bases = Rows::Random(2 * 777, 8);
  const Rows weights = Rows::Random(3, 8 * 5);
  const Filled one = filled(bases, weights, 5, 1);
  const Filled three = filled(bases, weights, 5, 3);
  for (std::size_t i = 0; i < one.curves.size(); ++i)
    EXPECT_TRUE((one.curves[i].array() == three.curves[i].array()).all());
}

TEST(Curves, ThatMayOverflowAreNotCertain) {
  const Rows bases = Rows::Constant(2, 3, 1e200);
  EXPECT_TRUE(filled(bases, Rows::Constant(1, 3, 1e80), 1, 1).certain);
  EXPECT_FALSE(filled(bases, Rows::Constant(1, 3, 1e110), 1, 1).certain);
}

}  // namespace leadthrough::curves_tests
