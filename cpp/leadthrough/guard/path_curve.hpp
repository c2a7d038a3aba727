#pragma once

// The natural cubic spline through rows, at the parameters 0, 1, 2, ...

#include <algorithm>
#include <cmath>

#include "leadthrough/base/matrix.hpp"

namespace leadthrough::guard {

class PathCurve {
 public:
  explicit PathCurve(const Eigen::Ref<const Rows>& rows)
      : rows_(rows), bends_(Rows::Zero(rows.rows(), rows.cols())) {
    // Tridiagonal: bends_(i - 1) + 4 bends_(i) + bends_(i + 1) = 6 second differences.
    const Eigen::Index last = rows_.rows() - 1;
    Eigen::ArrayXd above = Eigen::ArrayXd::Zero(last + 1);
    for (Eigen::Index i = 1; i < last; ++i) {
      const double pivot = 4.0 - above[i - 1];
      above[i] = 1.0 / pivot;
      bends_.row(i) =
          (6.0 * (rows_.row(i + 1) - 2.0 * rows_.row(i) + rows_.row(i - 1)) - bends_.row(i - 1)) /
          pivot;
    }
    for (Eigen::Index i = last - 1; i > 0; --i) bends_.row(i) -= above[i] * bends_.row(i + 1);
  }

  // At a row, exactly that.
  template <typename Row>
  void at(double place, Row row) const {
    const auto i = static_cast<Eigen::Index>(
        std::clamp(std::floor(place), 0.0, static_cast<double>(rows_.rows() - 2)));
    const double b = place - static_cast<double>(i), a = 1.0 - b;
    row = a * rows_.row(i) + b * rows_.row(i + 1) + ((a * a * a - a) / 6.0) * bends_.row(i) +
          ((b * b * b - b) / 6.0) * bends_.row(i + 1);
  }

 private:
  Rows rows_, bends_;
};

}  // namespace leadthrough::guard
