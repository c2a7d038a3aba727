#pragma once

// Curves of many weights over the same basis functions.

#include <functional>
#include <vector>

#include "leadthrough/base/matrix.hpp"

namespace leadthrough {

// A range of rows of a basis, or the same range of several bases below each other, such as values
// and derivatives. Called from several threads.
using BasisRows = std::function<Rows(Eigen::Index first, Eigen::Index count)>;

// For each row of weights, of which each of `curves` has as many as there are functions, one curve
// after the other: sums of the functions times the weights, a row a row of the basis, a column a
// curve, basis after basis, written to the place of the weights. They are the same on any number of
// threads. rows: of one basis. Returns whether all sums are certain to be finite.
bool fill_curves(const BasisRows& basis, Eigen::Index rows, const RowsRef& weights,
                 Eigen::Index curves, int threads, const std::vector<double*>& places);

}  // namespace leadthrough
