#pragma once

#include <vector>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/field/grid.hpp"

namespace leadthrough {

// The lower envelope of the parabolas values[p] + (spacing (q - p))^2, evaluated at every cell q of
// a row (Felzenszwalb and Huttenlocher 2012, "Distance transforms of sampled functions").
class LowerEnvelope {
 public:
  // For rows of at most `size` cells.
  LowerEnvelope(Index size, double spacing)
      : scale_(spacing * spacing),
        vertex_(size),
        height_(size),
        from_(size + 1),
        half_inverse_(size) {
    for (Index n = 1; n < size; ++n) half_inverse_[n] = 0.5 / static_cast<double>(n);
  }

  void transform(double* values, Index size) {
    if (build(values, size)) evaluate(values, size);
  }

 private:
  // All in units of the spacing. Returns true if there is at least one parabola.
  bool build(const double* values, Index size) {
    const double per_scale = 1.0 / scale_;
    count_ = 0;
    for (Index q = 0; q < size; ++q) {
      if (values[q] == kInfinity) continue;
      const double height = values[q] * per_scale + static_cast<double>(q * q);
      double crossing = -kInfinity;
      while (count_ > 0) {
        const Index last = count_ - 1;
        crossing = (height - height_[last]) * half_inverse_[q - vertex_[last]];
        if (crossing > from_[last]) break;
        --count_;
      }
      vertex_[count_] = q;
      height_[count_] = height;
      from_[count_] = count_ == 0 ? -kInfinity : crossing;
      ++count_;
    }
    from_[count_] = kInfinity;
    return count_ > 0;
  }

  void evaluate(double* values, Index size) {
    Index n = 0;
    const Index last = count_ - 1;
    base_.assign(values, values + size);
    for (Index q = 0; q < size; ++q) {
      while (n < last && from_[n + 1] < static_cast<double>(q)) ++n;
      const double cells = static_cast<double>(q - vertex_[n]);
      values[q] = base_[vertex_[n]] + scale_ * cells * cells;
    }
  }

  double scale_;
  Index count_ = 0;
  std::vector<Index> vertex_;   // each parabola's lowest cell
  std::vector<double> height_;  // its value at cell 0
  std::vector<double> from_;    // where it begins to be the lowest
  std::vector<double> half_inverse_;
  std::vector<double> base_;
};

}  // namespace leadthrough
