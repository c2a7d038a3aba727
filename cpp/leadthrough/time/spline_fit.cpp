// The normal equations of B-splines have a narrow band. They lose half of the digits, which one
// step of refinement by the residuals brings back.

#include "leadthrough/time/spline_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index kDegree = 5, kOrder = kDegree + 1;
constexpr Index kFirstSpans = 4;
// A span needs a few more samples than coefficients of its own, or it swings between them.
constexpr Index kMinSamples = 3;
// At corners of a path spans have fewer; of more than half of its samples they would be noise.
constexpr Index kNoise = 2;
// Each end weighs as much as the square of this many samples.
constexpr double kWeightOfEnds = 1e4;
// Weights of the third derivative over a path of length 1, as powers of ten: a bend of a thousandth
// of the path counts nothing at the first, one of the whole path much at the last.
constexpr double kSoftest = -32.0, kStiffest = 4.0, kStep = 0.25;
// Samples of a long path. Its pieces are looked for from few to many, first among every eighth
// sample; a smooth path needs so many that, without a penalty, they miss no sample by more than
// half of the tolerance.
constexpr Index kLong = 20'000, kThinning = 8, kFirstWidth = 128;
constexpr double kRoom = 0.5;

class Fit {
 public:
  Fit(const VectorRef& parameters, const RowsRef& q, const std::vector<Index>& breaks)
      : parameters_(parameters),
        q_(q),
        spans_(static_cast<Index>(breaks.size()) - 1),
        knots_(spans_ + 2 * kDegree + 1),
        basis_(parameters.size(), kOrder),
        span_(static_cast<std::size_t>(parameters.size())) {
    for (Index k = 0; k < knots_.size(); ++k) {
      const Index at = std::clamp<Index>(k - kDegree, 0, spans_);
      knots_[k] = parameters[breaks[static_cast<std::size_t>(at)]];
    }
    Index span = 0;
    for (Index i = 0; i < parameters.size(); ++i) {
      while (span + 1 < spans_ && i >= breaks[static_cast<std::size_t>(span + 1)]) ++span;
      span_[static_cast<std::size_t>(i)] = span;
      set_basis(i, span);
    }
    set_normal();
  }

  // Whether the equations have a solution.
  bool solve() {
    if (!factorize(0.0)) return false;
    check_interrupt();
    coefficients_ = solved(moments(q_));
    coefficients_ += solved(moments(missed(q_, coefficients_)));
    finish();
    return true;
  }

  // Whether there are pieces enough to be within the tolerance.
  bool can_follow(double tolerance) {
    if (!factorize(0.0)) return false;
    const Rows x = solved(moments(q_));
    for (Index j = 0; j < q_.cols(); ++j)
      if (!is_within(j, x.col(j), tolerance)) return false;
    return true;
  }

  // The same with each column as stiff as the tolerance allows.
  bool smooth(const CurveBounds& bounds, double tolerance) {
    set_penalty();
    coefficients_.resize(spans_ + kDegree, q_.cols());
    const Rows sums = moments(q_);
    for (Index j = 0; j < q_.cols(); ++j) {
      const auto fit = [&](double exponent) -> std::optional<Rows> {
        check_interrupt();
        if (!factorize(std::pow(10.0, exponent))) return {};
        Rows x = solved(sums.col(j));
        // A curve lies between its coefficients.
        x = x.cwiseMax(bounds.lower[j]).cwiseMin(bounds.upper[j]);
        if (!is_within(j, x, tolerance)) return {};
        return x;
      };
      std::optional<Rows> best = fit(kSoftest);
      if (!best) return false;
      Index low = 0, high = static_cast<Index>((kStiffest - kSoftest) / kStep) + 1;
      while (high - low > 1) {
        const Index middle = (low + high) / 2;
        std::optional<Rows> x = fit(kSoftest + kStep * static_cast<double>(middle));
        (x ? low : high) = middle;
        if (x) best.swap(x);
      }
      coefficients_.col(j) = *best;
    }
    finish();
    return true;
  }

  // Whether some sample of each span is missed by more than the tolerance.
  std::vector<bool> misses(double tolerance) const {
    std::vector<bool> result(static_cast<std::size_t>(spans_), false);
    for (Index i = 0; i < q_.rows(); ++i)
      if (residuals_.row(i).cwiseAbs().maxCoeff() > tolerance)
        result[static_cast<std::size_t>(span_[static_cast<std::size_t>(i)])] = true;
    return result;
  }

  Rows pieces() const {
    Rows table(spans_ * kOrder, q_.cols());
    for (Index span = 0; span < spans_; ++span) {
      table.middleRows(span * kOrder, kOrder) =
          derivatives(coefficients_.middleRows(span, kOrder), span);
      double factorial = 1.0;
      for (Index order = 1; order < kOrder; ++order) {
        factorial *= static_cast<double>(order);
        table.row(span * kOrder + order) /= factorial;
      }
    }
    return table;
  }

 private:
  // Values of the basis functions that do not vanish (The NURBS Book, algorithm A2.2).
  void set_basis(Index i, Index span) {
    const double x = parameters_[i], *t = knots_.data() + span + kDegree;
    double* value = basis_.row(i).data();
    std::array<double, kOrder> left{}, right{};
    value[0] = 1.0;
    for (Index degree = 1; degree <= kDegree; ++degree) {
      left[static_cast<std::size_t>(degree)] = x - t[1 - degree];
      right[static_cast<std::size_t>(degree)] = t[degree] - x;
      double saved = 0.0;
      for (Index k = 0; k < degree; ++k) {
        const double r = right[static_cast<std::size_t>(k + 1)];
        const double l = left[static_cast<std::size_t>(degree - k)];
        const double part = value[k] / (r + l);
        value[k] = saved + r * part;
        saved = l * part;
      }
      value[degree] = saved;
    }
  }

  double weight(Index i) const {
    return i == 0 || i + 1 == q_.rows() ? kWeightOfEnds * kWeightOfEnds : 1.0;
  }

  // The band of the normal matrix: row i holds the diagonal, then the column below it.
  void set_normal() {
    normal_ = Rows::Zero(spans_ + kDegree, kOrder);
    for (Index i = 0; i < q_.rows(); ++i) {
      check_interrupt(i);
      const Index first = span_[static_cast<std::size_t>(i)];
      for (Index k = 0; k < kOrder; ++k)
        for (Index m = k; m < kOrder; ++m)
          normal_(first + k, m - k) += weight(i) * basis_(i, k) * basis_(i, m);
    }
  }

  // The integral of the squared third derivative over a path of length 1, in the same form.
  void set_penalty() {
    penalty_ = Rows::Zero(spans_ + kDegree, kOrder);
    const double length = parameters_[parameters_.size() - 1] - parameters_[0];
    for (Index span = 0; span < spans_; ++span) {
      const Rows terms = derivatives(Rows::Identity(kOrder, kOrder), span);
      const double width = (knots_[span + kOrder] - knots_[span + kDegree]) / length;
      Eigen::Matrix3d moments;
      Eigen::Matrix<double, 3, kOrder> third;
      for (Index a = 0; a < 3; ++a) {
        const double factor = std::array{1.0, 1.0, 0.5}[static_cast<std::size_t>(a)];
        third.row(a) = factor * std::pow(length, static_cast<double>(3 + a)) * terms.row(3 + a);
        for (Index b = 0; b < 3; ++b)
          moments(a, b) =
              std::pow(width, static_cast<double>(a + b + 1)) / static_cast<double>(a + b + 1);
      }
      const Eigen::Matrix<double, kOrder, kOrder> part = third.transpose() * moments * third;
      for (Index k = 0; k < kOrder; ++k)
        for (Index m = k; m < kOrder; ++m) penalty_(span + k, m - k) += part(k, m);
    }
  }

  // The matrix as L D L^T: row i holds D, then the column of L below it.
  bool factorize(double stiffness) {
    const Index size = spans_ + kDegree;
    band_ = normal_;
    if (stiffness > 0.0) band_ += stiffness * static_cast<double>(q_.rows()) * penalty_;
    for (Index i = 0; i < size; ++i) {
      const double pivot = band_(i, 0);
      if (!(pivot > 0.0)) return false;
      const Index reach = std::min(kDegree, size - 1 - i);
      for (Index k = 1; k <= reach; ++k) {
        const double factor = band_(i, k) / pivot;
        for (Index m = k; m <= reach; ++m) band_(i + k, m - k) -= factor * band_(i, m);
      }
      for (Index k = 1; k <= reach; ++k) band_(i, k) /= pivot;
    }
    return true;
  }

  // Right sides of the normal equations, one column a coordinate.
  Rows moments(const RowsRef& samples) const {
    Rows sums = Rows::Zero(spans_ + kDegree, samples.cols());
    for (Index i = 0; i < samples.rows(); ++i) {
      const double* sample = samples.row(i).data();
      for (Index k = 0; k < kOrder; ++k) {
        const double factor = weight(i) * basis_(i, k);
        double* sum = sums.row(span_[static_cast<std::size_t>(i)] + k).data();
        for (Index j = 0; j < samples.cols(); ++j) sum[j] += factor * sample[j];
      }
    }
    return sums;
  }

  // Their solution.
  Rows solved(Rows x) const {
    const Index size = spans_ + kDegree;
    for (Index i = 0; i < size; ++i)
      for (Index k = 1; k <= std::min(kDegree, size - 1 - i); ++k)
        x.row(i + k) -= band_(i, k) * x.row(i);
    for (Index i = size - 1; i >= 0; --i) {
      x.row(i) /= band_(i, 0);
      for (Index k = 1; k <= std::min(kDegree, size - 1 - i); ++k)
        x.row(i) -= band_(i, k) * x.row(i + k);
    }
    return x;
  }

  // Whether a column of the samples is missed nowhere by more than the tolerance.
  bool is_within(Index column, const Rows& coefficients, double tolerance) const {
    for (Index i = 0; i < q_.rows(); ++i) {
      double residual = q_(i, column);
      const Index first = span_[static_cast<std::size_t>(i)];
      for (Index k = 0; k < kOrder; ++k) residual -= basis_(i, k) * coefficients(first + k, 0);
      if (!(std::abs(residual) <= tolerance)) return false;
    }
    return true;
  }

  Rows missed(const Rows& samples, const Rows& coefficients) const {
    Rows residuals = samples;
    for (Index i = 0; i < samples.rows(); ++i) {
      double* residual = residuals.row(i).data();
      for (Index k = 0; k < kOrder; ++k) {
        const double* own = coefficients.row(span_[static_cast<std::size_t>(i)] + k).data();
        for (Index j = 0; j < samples.cols(); ++j) residual[j] -= basis_(i, k) * own[j];
      }
    }
    return residuals;
  }

  // A curve begins and ends at its outer coefficients.
  void finish() {
    coefficients_.row(0) = q_.row(0);
    coefficients_.row(coefficients_.rows() - 1) = q_.row(q_.rows() - 1);
    residuals_ = missed(q_, coefficients_);
  }

  // All derivatives where a span begins, from its coefficients.
  Rows derivatives(Rows local, Index span) const {
    Rows result(kOrder, local.cols());
    for (Index order = 0; order < kOrder; ++order) {
      if (order > 0) differentiate(local, span, order);
      result.row(order) = at_start(local, span, order);
    }
    return result;
  }

  // Coefficients of the derivative of `order` from those of the one before.
  void differentiate(Rows& local, Index span, Index order) const {
    const Index degree = kDegree - order + 1;
    for (Index j = kDegree; j >= order; --j) {
      const double width = knots_[span + j + degree] - knots_[span + j];
      local.row(j) = static_cast<double>(degree) / width * (local.row(j) - local.row(j - 1));
    }
  }

  // The derivative of `order` where the span begins, by de Boor's recursion.
  Eigen::RowVectorXd at_start(const Rows& local, Index span, Index order) const {
    const Index degree = kDegree - order;
    const double x = knots_[span + kDegree];
    Rows point = local.bottomRows(degree + 1);
    for (Index level = 1; level <= degree; ++level)
      for (Index j = degree; j >= level; --j) {
        const double* t = knots_.data() + span + order + j;
        const double share = (x - t[0]) / (t[degree - level + 1] - t[0]);
        point.row(j) = (1.0 - share) * point.row(j - 1) + share * point.row(j);
      }
    return point.row(degree);
  }

  const VectorRef parameters_;
  const RowsRef q_;
  const Index spans_;
  VectorXd knots_;
  Rows basis_;               // (samples, order)
  std::vector<Index> span_;  // of each sample
  Rows normal_, penalty_, band_, coefficients_, residuals_;
};

// Whether spans have samples enough; but for some at corners, if there may be any.
bool wide_enough(const std::vector<Index>& breaks, bool corners) {
  Index narrow = 0;
  for (std::size_t k = 1; k < breaks.size(); ++k) {
    if (breaks[k] - breaks[k - 1] < kMinSamples) ++narrow;
  }
  return narrow == 0 || (corners && kNoise * narrow <= breaks.back());
}

// Breaks of equally many samples.
std::vector<Index> even_breaks(Index samples, Index spans) {
  std::vector<Index> breaks;
  for (Index k = 0; k <= spans; ++k) breaks.push_back(k * (samples - 1) / spans);
  return breaks;
}

// Breaks with those spans halved that miss a sample. At a corner of the path, where these have
// hardly any, those beside them are halved too, down to a sample each: there the spline
// interpolates.
std::vector<Index> halved(const std::vector<Index>& breaks, const std::vector<bool>& misses) {
  const auto width = [&](std::size_t span) { return breaks[span + 1] - breaks[span]; };
  std::vector<bool> halves = misses;
  for (std::size_t span = 0; span < misses.size(); ++span)
    if (misses[span] && width(span) < 2 * kMinSamples)
      for (std::size_t k = span - std::min<std::size_t>(span, kDegree);
           k < std::min<std::size_t>(span + kOrder, misses.size()); ++k)
        halves[k] = true;
  std::vector<Index> finer{breaks[0]};
  for (std::size_t span = 0; span < halves.size(); ++span) {
    if (halves[span] && width(span) > 1) finer.push_back((breaks[span] + breaks[span + 1]) / 2);
    finer.push_back(breaks[span + 1]);
  }
  return finer;
}

// halved_fit of every so many samples: its pieces are nearly those that all of them need.
SplineFit thinned_fit(const VectorRef& parameters, const RowsRef& q, double tolerance,
                      bool corners);

// Halves pieces until all are within the tolerance; no coefficients if they become too short.
SplineFit halved_fit(const VectorRef& parameters, const RowsRef& q, double tolerance,
                     bool corners) {
  SplineFit found;
  std::vector<Index>& breaks = found.breaks;
  breaks = q.rows() > kLong ? thinned_fit(parameters, q, tolerance, corners).breaks
                            : even_breaks(q.rows(), kFirstSpans);
  std::vector<Index> finer = breaks;
  while (wide_enough(finer, corners)) {
    check_interrupt();
    breaks.swap(finer);
    Fit fit(parameters, q, breaks);
    if (!fit.solve()) break;
    const std::vector<bool> misses = fit.misses(tolerance);
    if (std::none_of(misses.begin(), misses.end(), [](bool missed) { return missed; })) {
      found.coefficients = fit.pieces();
      break;
    }
    finer = halved(breaks, misses);
    if (finer.size() == breaks.size()) break;
  }
  return found;
}

SplineFit thinned_fit(const VectorRef& parameters, const RowsRef& q, double tolerance,
                      bool corners) {
  const Index count = (q.rows() - 1) / kThinning + 1;
  VectorXd some(count);
  Rows rows(count, q.cols());
  for (Index i = 0; i < count; ++i) {
    some[i] = parameters[i * kThinning];
    rows.row(i) = q.row(i * kThinning);
  }
  SplineFit fit = halved_fit(some, rows, tolerance, corners);
  for (Index& at : fit.breaks) at *= kThinning;
  fit.breaks.back() = q.rows() - 1;
  return fit;
}

}  // namespace

SplineFit fit_spline(const VectorRef& parameters, const RowsRef& q, double tolerance,
                     bool corners) {
  check_argument(q.rows() == parameters.size() && q.cols() > 0,
                 "q: expected one row for each parameter");
  check_argument(q.rows() > 6, "q: expected at least seven rows");
  SplineFit fit = halved_fit(parameters, q, tolerance, corners);
  if (fit.coefficients.size() == 0) return {};
  return fit;
}

SplineFit smooth_spline(const VectorRef& parameters, const RowsRef& q, double tolerance,
                        const CurveBounds& bounds) {
  check_argument(q.rows() == parameters.size() && q.cols() > 0,
                 "q: expected one row for each parameter");
  check_argument(q.rows() > 6, "q: expected at least seven rows");
  check_argument(bounds.lower.size() == q.cols() && bounds.upper.size() == q.cols(),
                 "bounds: expected one value a joint");
  const Index most = std::max<Index>((q.rows() - 1) / kMinSamples, 1);
  Index spans = q.rows() > kLong ? q.rows() / kFirstWidth : most;
  while (true) {
    const std::vector<Index> breaks = even_breaks(q.rows(), spans);
    Fit fit(parameters, q, breaks);
    if (spans < most && !fit.can_follow(kRoom * tolerance)) {
      spans = std::min(2 * spans, most);
      continue;
    }
    if (!fit.smooth(bounds, tolerance)) return {};
    return {breaks, fit.pieces()};
  }
}

std::vector<Index> rows_apart(const RowsRef& q, double tolerance) {
  check_argument(q.size() > 0, "q: expected at least one number");
  std::vector<Index> found{0};
  for (Index i = 1; i < q.rows(); ++i)
    if ((q.row(i) - q.row(found.back())).cwiseAbs().maxCoeff() > tolerance) found.push_back(i);
  return found;
}

}  // namespace leadthrough
