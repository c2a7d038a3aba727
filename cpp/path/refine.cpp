#include "path/refine.hpp"

#include <algorithm>
#include <cmath>

#include "path/band.hpp"

namespace leadthrough::path {

namespace {

// Weights beside a squared second difference, rad^2.
constexpr double kTip = 1e6;          // a squared m, or 0.3 m a rad
constexpr double kClearance = 1e4;    // a squared m
constexpr double kSpeed = 1e-2;       // a squared first difference
constexpr double kPosture = 1e-4;     // a squared rad
constexpr double kBand = 0.01;        // m beyond its margin and room from which a pair counts
constexpr double kLongestStep = 0.3;  // of a joint, rad or m
constexpr int kIterations = 40;
constexpr double kLeastGain = 1e-3;  // of the cost, in an iteration

// The cost at a curve and its quadratic model.
struct Model {
  double cost = 0.0;
  BandMatrix hessian;
  Eigen::VectorXd descent;  // the negative gradient
};

class Refinement {
 public:
  Refinement(const Chain& chain, const std::vector<Knot>& knots, ClearanceTest& test,
             const std::vector<double>& margins)
      : chain_(chain), knots_(knots), test_(test), margins_(margins), n_(chain.joints()) {}

  void run(std::vector<JointArray>& q) {
    double damping = 1e-3;
    Model model = model_at(q);
    for (int i = 0; i < kIterations; ++i) {
      std::vector<JointArray> trial = q;
      if (!step(model, damping, trial)) break;
      Model next = model_at(trial);
      if (next.cost >= model.cost) {
        damping *= 10.0;
        if (damping > 1e6) break;
        continue;
      }
      const double gain = model.cost - next.cost;
      q = std::move(trial);
      model = std::move(next);
      damping = std::max(0.2 * damping, 1e-9);
      if (gain < kLeastGain * model.cost) break;
    }
  }

 private:
  int size() const { return static_cast<int>(knots_.size()); }

  Model model_at(const std::vector<JointArray>& q) {
    Model model{0.0, BandMatrix(size() * n_, 3 * n_ - 1), Eigen::VectorXd::Zero(size() * n_)};
    for (int k = 0; k < size(); ++k) {
      add_tip(k, q, model);
      add_clearance(k, q, model);
      add_posture(k, q, model);
      if (k > 0) add_difference(k - 1, {-1.0, 1.0, 0.0}, kSpeed, q, model);
      if (k > 1) add_difference(k - 2, {1.0, -2.0, 1.0}, 1.0, q, model);
    }
    return model;
  }

  void add_tip(int k, const std::vector<JointArray>& q, Model& model) {
    const auto at = static_cast<std::size_t>(k);
    knots_[at].task.evaluate(q[at], error_);
    const auto rows = error_.rows;
    model.cost += kTip * error_.error.head(rows).squaredNorm();
    for (int i = 0; i < n_; ++i) {
      const auto& column = error_.columns[static_cast<std::size_t>(i)];
      model.descent[k * n_ + i] += kTip * column.head(rows).dot(error_.error.head(rows));
      for (int j = 0; j <= i; ++j)
        model.hessian.at(k * n_ + i, k * n_ + j) +=
            kTip * column.head(rows).dot(error_.columns[static_cast<std::size_t>(j)].head(rows));
    }
  }

  void add_clearance(int k, const std::vector<JointArray>& q, Model& model) {
    const auto at = static_cast<std::size_t>(k);
    test_.near(q[at].data(), knots_[at].room + kBand, near_);
    for (const NearPair& pair : near_) {
      const double missing = margins_[pair.pair] + knots_[at].room - pair.distance;
      if (missing <= 0.0) continue;
      model.cost += kClearance * missing * missing;
      for (int i = 0; i < n_; ++i) {
        const double slope = kClearance * pair.gradient[static_cast<std::size_t>(i)];
        model.descent[k * n_ + i] += slope * missing;
        for (int j = 0; j <= i; ++j)
          model.hessian.at(k * n_ + i, k * n_ + j) +=
              slope * pair.gradient[static_cast<std::size_t>(j)];
      }
    }
  }

  void add_posture(int k, const std::vector<JointArray>& q, Model& model) {
    const auto at = static_cast<std::size_t>(k);
    for (int i = 0; i < n_; ++i) {
      const double away =
          knots_[at].posture[static_cast<std::size_t>(i)] - q[at][static_cast<std::size_t>(i)];
      if (!std::isfinite(away)) continue;
      model.cost += kPosture * away * away;
      model.descent[k * n_ + i] += kPosture * away;
      model.hessian.at(k * n_ + i, k * n_ + i) += kPosture;
    }
  }

  // A weighted sum of up to three knots from `first` on, to be small.
  void add_difference(int first, const std::array<double, 3>& weights, double scale,
                      const std::vector<JointArray>& q, Model& model) {
    for (int i = 0; i < n_; ++i) {
      double sum = 0.0;
      for (int a = 0; a < 3; ++a)
        if (weights[static_cast<std::size_t>(a)] != 0.0)
          sum += weights[static_cast<std::size_t>(a)] *
                 q[static_cast<std::size_t>(first + a)][static_cast<std::size_t>(i)];
      model.cost += scale * sum * sum;
      for (int a = 0; a < 3; ++a) {
        const double slope = scale * weights[static_cast<std::size_t>(a)];
        if (slope == 0.0) continue;
        model.descent[(first + a) * n_ + i] -= slope * sum;
        for (int b = 0; b <= a; ++b)
          model.hessian.at((first + a) * n_ + i, (first + b) * n_ + i) +=
              slope * weights[static_cast<std::size_t>(b)];
      }
    }
  }

  // Joints at a limit that would be pushed out stay where they are.
  bool step(const Model& model, double damping, std::vector<JointArray>& q) const {
    BandMatrix hessian = model.hessian;
    Eigen::VectorXd change = model.descent;
    for (int row = 0; row < size() * n_; ++row) {
      hessian.at(row, row) += damping;
      if (!held(row, model, q)) continue;
      change[row] = 0.0;
      hessian.hold(row);
    }
    if (!hessian.solve(change)) return false;
    const double longest = change.cwiseAbs().maxCoeff();
    if (longest > kLongestStep) change *= kLongestStep / longest;
    for (int row = 0; row < size() * n_; ++row) {
      const int i = row % n_;
      double& value = q[static_cast<std::size_t>(row / n_)][static_cast<std::size_t>(i)];
      value = std::clamp(value + change[row], chain_.lower[i], chain_.upper[i]);
    }
    return true;
  }

  bool held(int row, const Model& model, const std::vector<JointArray>& q) const {
    const int i = row % n_;
    const double value = q[static_cast<std::size_t>(row / n_)][static_cast<std::size_t>(i)];
    return model.descent[row] < 0.0 ? value <= chain_.lower[i] : value >= chain_.upper[i];
  }

  const Chain& chain_;
  const std::vector<Knot>& knots_;
  ClearanceTest& test_;
  const std::vector<double>& margins_;
  int n_;
  TipError error_;
  std::vector<NearPair> near_;
};

}  // namespace

void refine(const Chain& chain, const std::vector<Knot>& knots, ClearanceTest& test,
            const std::vector<double>& margins, std::vector<JointArray>& q) {
  Refinement(chain, knots, test, margins).run(q);
}

}  // namespace leadthrough::path
