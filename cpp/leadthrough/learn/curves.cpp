#include "leadthrough/learn/curves.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>

#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/base/parallel.hpp"

namespace leadthrough {
namespace {

constexpr Eigen::Index kRunOfRows = 64;  // that a thread takes at a time: they stay in its cache
constexpr int kAtOnce = 4;               // rows and columns whose sums stay in registers
constexpr double kSurelyFinite = 1e300;

using Lanes = Eigen::Array<double, kAtOnce, 1>;

// Rows of a basis, four side by side for each function; the last are filled up with zeros.
class Panels {
 public:
  explicit Panels(const RowsRef& basis)
      : rows_(basis.rows()),
        functions_(basis.cols()),
        values_((basis.rows() + kAtOnce - 1) / kAtOnce * functions_, kAtOnce) {
    values_.bottomRows(functions_).setZero();
    for (Eigen::Index i = 0; i < rows_; ++i)
      values_.col(i % kAtOnce).segment(i / kAtOnce * functions_, functions_) =
          basis.row(i).transpose();
  }

  // Writes the sums for `Columns` curves, whose weights lie one curve after the other.
  template <int Columns>
  void write(const double* weights, double* result, Eigen::Index stride) const {
    for (Eigen::Index first = 0; first < rows_; first += kAtOnce) {
      Lanes sums[Columns];
      for (Lanes& sum : sums) sum.setZero();
      const double* panel = values_.data() + first * functions_;
      for (Eigen::Index j = 0; j < functions_; ++j) {
        const Lanes function = Eigen::Map<const Lanes, Eigen::Aligned16>(panel + j * kAtOnce);
        for (int c = 0; c < Columns; ++c) sums[c] += function * weights[c * functions_ + j];
      }
      const Eigen::Index count = std::min<Eigen::Index>(kAtOnce, rows_ - first);
      for (Eigen::Index i = 0; i < count; ++i)
        for (int c = 0; c < Columns; ++c) result[(first + i) * stride + c] = sums[c][i];
    }
  }

  void write_all(const double* weights, Eigen::Index curves, double* result) const {
    Eigen::Index c = 0;
    for (; c + kAtOnce <= curves; c += kAtOnce)
      write<kAtOnce>(weights + c * functions_, result + c, curves);
    weights += c * functions_;
    if (curves - c == 3) write<3>(weights, result + c, curves);
    if (curves - c == 2) write<2>(weights, result + c, curves);
    if (curves - c == 1) write<1>(weights, result + c, curves);
  }

 private:
  Eigen::Index rows_, functions_;
  Eigen::Matrix<double, Eigen::Dynamic, kAtOnce, Eigen::RowMajor> values_;
};

}  // namespace

bool fill_curves(const BasisRows& basis, Eigen::Index rows, const RowsRef& weights,
                 Eigen::Index curves, int threads, const std::vector<double*>& places) {
  const Eigen::Index motions = weights.rows();
  const double heaviest = weights.cwiseAbs().maxCoeff();
  const Eigen::Index runs = (rows + kRunOfRows - 1) / kRunOfRows;
  std::atomic<bool> certain{true};
  for_each_block(rows, kRunOfRows, threads, [&](Eigen::Index first, Eigen::Index end) {
    const Eigen::Index run = first / kRunOfRows, count = end - first;
    const Rows values = basis(first, count);
    const double largest = values.cwiseAbs().maxCoeff() * heaviest;
    if (!(static_cast<double>(values.cols()) * largest < kSurelyFinite)) certain = false;
    for (Eigen::Index part = 0; part < values.rows() / count; ++part) {
      const Panels panels(values.middleRows(part * count, count));
      // Threads begin far from each other, so that they do not contend for the same new pages.
      const Eigen::Index begin = run * motions / runs;
      for (Eigen::Index i = 0; i < motions; ++i) {
        check_interrupt(i);
        const Eigen::Index motion = (begin + i) % motions;
        double* place = places[static_cast<std::size_t>(motion)] + (part * rows + first) * curves;
        panels.write_all(weights.row(motion).data(), curves, place);
      }
    }
  });
  return certain;
}

}  // namespace leadthrough
