#include "leadthrough/time/curve_values.hpp"

#include <algorithm>
#include <vector>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

using Eigen::Index;

namespace {

// sums += row * power * factor; the compiler unrolls a number of columns that it knows.
template <Index known>
void add_row(const double* row, Index columns, double power, double factor, double* sums) {
  const Index width = known > 0 ? known : columns;
  for (Index j = 0; j < width; ++j) sums[j] += row[j] * power * factor;
}

using AddRow = void (*)(const double*, Index, double, double, double*);

AddRow add_row_of(Index columns) {
  switch (columns) {
    case 1:
      return add_row<1>;
    case 2:
      return add_row<2>;
    case 3:
      return add_row<3>;
    case 6:
      return add_row<6>;
    case 7:
      return add_row<7>;
    default:
      return add_row<0>;
  }
}

// Factors of each power's derivative of an order: k (k - 1) ..., as many as the order.
std::vector<double> falling_factors(Index terms, int order) {
  std::vector<double> factors(static_cast<std::size_t>(terms), 1.0);
  for (Index k = 0; k < terms; ++k)
    for (Index i = k; i > k - order && i >= 0; --i)
      factors[static_cast<std::size_t>(k)] *= static_cast<double>(i);
  return factors;
}

// Binomial coefficients of a degree.
std::vector<double> binomials(Index degree) {
  std::vector<double> result(static_cast<std::size_t>(degree) + 1, 1.0);
  for (Index k = 1; k <= degree; ++k)
    result[static_cast<std::size_t>(k)] = result[static_cast<std::size_t>(k) - 1] *
                                          static_cast<double>(degree - k + 1) /
                                          static_cast<double>(k);
  return result;
}

}  // namespace

Rows polynomial_values(const VectorRef& knots, const RowsRef& coefficients, const VectorRef& times,
                       int order) {
  check_argument(knots.size() > 1, "knots: expected at least two");
  check_argument(coefficients.size() > 0 && coefficients.rows() % (knots.size() - 1) == 0,
                 "coefficients: expected as many rows for each piece");
  check_argument(order >= 0, "order: expected a derivative");
  const Index pieces = knots.size() - 1, columns = coefficients.cols();
  const Index terms = coefficients.rows() / pieces;
  const std::vector<double> factors = falling_factors(terms, order);
  const AddRow add = add_row_of(columns);
  Rows result = Rows::Zero(times.size(), columns);
  Index piece = 0;
  for (Index i = 0; i < times.size(); ++i) {
    check_interrupt(i);
    const double t = times[i];
    // Times mostly rise: the next piece is this one or near.
    while (piece > 0 && t < knots[piece]) --piece;
    while (piece + 1 < pieces && t >= knots[piece + 1]) ++piece;
    double power = 1.0;
    for (Index k = order; k < terms; ++k) {
      add(coefficients.data() + (piece * terms + k) * columns, columns, power,
          factors[static_cast<std::size_t>(k)], result.data() + i * columns);
      power *= t - knots[piece];
    }
  }
  return result;
}

Rows bezier_values(const RowsRef& points, const VectorRef& fractions) {
  check_argument(points.size() > 0, "points: expected at least one");
  const Index degree = points.rows() - 1, columns = points.cols();
  const std::vector<double> ways = binomials(degree);
  const AddRow add = add_row_of(columns);
  std::vector<double> left(ways.size(), 1.0);  // powers of what is left of the domain
  Rows result = Rows::Zero(fractions.size(), columns);
  for (Index i = 0; i < fractions.size(); ++i) {
    check_interrupt();
    const double passed = fractions[i], rest = 1.0 - passed;
    for (std::size_t k = 1; k < left.size(); ++k) left[k] = left[k - 1] * rest;
    double power = 1.0;
    for (Index k = 0; k <= degree; ++k) {
      add(points.data() + k * columns, columns, power * left[static_cast<std::size_t>(degree - k)],
          ways[static_cast<std::size_t>(k)], result.data() + i * columns);
      power *= passed;
    }
  }
  return result;
}

}  // namespace leadthrough
