#pragma once

// Symmetric positive definite matrices whose elements far from the diagonal are zero.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

namespace leadthrough::path {

class BandMatrix {
 public:
  // width: how many diagonals below the main one are not zero.
  BandMatrix(int size, int width)
      : size_(size), width_(width), rows_(static_cast<std::size_t>(size * (width + 1)), 0.0) {}

  // row >= column >= row - width.
  double& at(int row, int column) { return rows_[place(row, column)]; }

  // Fixes an unknown: its solution is its right-hand side.
  void hold(int i) {
    for (int j = std::max(0, i - width_); j < i; ++j) at(i, j) = 0.0;
    for (int j = i + 1; j <= std::min(size_ - 1, i + width_); ++j) at(j, i) = 0.0;
    at(i, i) = 1.0;
  }

  // Solves in place and stores the factor; false if the matrix is not positive definite.
  bool solve(Eigen::VectorXd& x) {
    for (int i = 0; i < size_; ++i) {
      const int first = std::max(0, i - width_);
      for (int j = first; j <= i; ++j) {
        const int from = std::max(first, j - width_);
        double sum = at(i, j);
        const double* a = &rows_[place(i, from)];
        const double* b = &rows_[place(j, from)];
        for (int k = 0; k < j - from; ++k) sum -= a[k] * b[k];
        if (j < i) {
          at(i, j) = sum / at(j, j);
        } else {
          if (!(sum > 0.0)) return false;
          at(i, i) = std::sqrt(sum);
        }
      }
    }
    for (int i = 0; i < size_; ++i) {
      for (int k = std::max(0, i - width_); k < i; ++k) x[i] -= at(i, k) * x[k];
      x[i] /= at(i, i);
    }
    for (int i = size_ - 1; i >= 0; --i) {
      x[i] /= at(i, i);
      for (int k = std::max(0, i - width_); k < i; ++k) x[k] -= at(i, k) * x[i];
    }
    return true;
  }

 private:
  std::size_t place(int row, int column) const {
    return static_cast<std::size_t>(row * (width_ + 1) + column - row + width_);
  }

  int size_, width_;
  std::vector<double> rows_;
};

}  // namespace leadthrough::path
