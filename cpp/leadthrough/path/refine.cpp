#include "leadthrough/path/refine.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/path/band.hpp"

namespace leadthrough::path {

namespace {

// Weights beside a squared second difference, rad^2.
constexpr double kTip = 1e6;         // a squared m, or 0.3 m a rad
constexpr double kOnSurface = 0.03;  // on the surface of a tube,
constexpr double kOutside = 100.0;   // a square of what is beyond
constexpr double kInside = 0.94;     // of it, and
constexpr double kBend = 20.0;       // a squared second difference of places in it
constexpr double kClearance = 1e4;   // a squared m
constexpr double kSpeed = 1e-2;      // a squared first difference
constexpr double kPosture = 1e-4;    // a squared rad
constexpr double kBand = 0.01;       // m beyond its margin and room from which a pair counts
constexpr double kMaxStep = 0.3;     // of a joint, rad or m
constexpr int kIterations = 40;
constexpr double kMinGain = 1e-3;  // of the cost, in an iteration

// The cost at a curve and its quadratic model.
struct Model {
  double cost = 0.0;
  BandMatrix hessian;
  Eigen::VectorXd descent;  // the negative gradient
};

// Position of a knot's tip in the tube, and its change with each joint.
struct Place {
  TubePlace place;
  std::array<TubePlace, kMaxJoints> moves;
};

class Refinement {
 public:
  Refinement(const Chain& chain, const std::vector<Knot>& knots, ClearanceTest& test,
             const std::vector<double>& margins)
      : chain_(chain),
        knots_(knots),
        test_(test),
        margins_(margins),
        n_(chain.joints()),
        places_(knots.size()) {}

  void run(std::vector<JointArray>& q) {
    double damping = 1e-3;
    Model model = model_at(q);
    for (int i = 0; i < kIterations; ++i) {
      check_interrupt();
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
      if (gain < kMinGain * model.cost) break;
    }
  }

 private:
  int size() const { return static_cast<int>(knots_.size()); }

  Model model_at(const std::vector<JointArray>& q) {
    Model model{0.0, BandMatrix(size() * n_, 3 * n_ - 1), Eigen::VectorXd::Zero(size() * n_)};
    for (int k = 0; k < size(); ++k) {
      check_interrupt();
      add_tip(k, q, model);
      add_clearance(k, q, model);
      add_posture(k, q, model);
      if (k > 0) add_difference(k - 1, {-1.0, 1.0, 0.0}, kSpeed, q, model);
      if (k > 1) add_difference(k - 2, {1.0, -2.0, 1.0}, 1.0, q, model);
      if (k > 1) add_bend(k - 2, model);
    }
    return model;
  }

  void add_tip(int k, const std::vector<JointArray>& q, Model& model) {
    const auto at = static_cast<std::size_t>(k);
    const TipTask& task = knots_[at].task;
    task.evaluate(q[at], error_);
    if (task.tube()) add_place(k, *task.tube(), model);
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

  // Pulls the tip towards its path, softly in the tube and hard outside it. Errors along the tube's
  // axes are then zeroed.
  void add_place(int k, const Tube& tube, Model& model) {
    auto& [place, moves] = places_[static_cast<std::size_t>(k)];
    place = tube.place(error_.error);
    const double length = place.norm(), beyond = std::max(length - kInside, 0.0);
    model.cost += kOnSurface * place.squaredNorm() + kOutside * beyond * beyond;
    std::array<double, kMaxJoints> outwards{};
    for (std::size_t i = 0; i < static_cast<std::size_t>(n_); ++i) {
      moves[i] = tube.place(error_.columns[i]);
      if (beyond > 0.0) outwards[i] = moves[i].dot(place) / length;
    }
    for (int i = 0; i < n_; ++i) {
      const auto a = static_cast<std::size_t>(i);
      model.descent[k * n_ + i] +=
          kOnSurface * moves[a].dot(place) + kOutside * beyond * outwards[a];
      for (int j = 0; j <= i; ++j) {
        const auto b = static_cast<std::size_t>(j);
        model.hessian.at(k * n_ + i, k * n_ + j) +=
            kOnSurface * moves[a].dot(moves[b]) + kOutside * outwards[a] * outwards[b];
      }
    }
    for (int row = 0; row < tube.dimension(); ++row) {
      const int gone = tube.rows[static_cast<std::size_t>(row)];
      error_.error[gone] = 0.0;
      for (Vector6& column : error_.columns) column[gone] = 0.0;
    }
  }

  // The tip leaves its path and returns smoothly.
  void add_bend(int first, Model& model) {
    constexpr std::array<double, 3> kWeights{1.0, -2.0, 1.0};
    const auto at = static_cast<std::size_t>(first);
    const auto dimension = places_[at + 1].place.size();
    if (dimension == 0 || !fits(at, dimension) || !fits(at + 2, dimension)) return;
    TubePlace bend = TubePlace::Zero(dimension);
    for (std::size_t a = 0; a < 3; ++a)
      if (places_[at + a].place.size() > 0) bend += kWeights[a] * places_[at + a].place;
    model.cost += kBend * bend.squaredNorm();
    for (int a = 0; a < 3 * n_; ++a) {
      const TubePlace slope = kBend * slope_of_bend(at, a, kWeights);
      model.descent[first * n_ + a] += slope.dot(bend);
      for (int b = 0; b <= a; ++b)
        model.hessian.at(first * n_ + a, first * n_ + b) +=
            slope.dot(slope_of_bend(at, b, kWeights));
    }
  }

  // True if a knot is in a tube of this dimension (0: on the path).
  bool fits(std::size_t knot, Eigen::Index dimension) const {
    const auto own = places_[knot].place.size();
    return own == dimension || own == 0;
  }

  // Derivative by unknown i of three knots.
  TubePlace slope_of_bend(std::size_t first, int i, const std::array<double, 3>& weights) const {
    const auto knot = static_cast<std::size_t>(i / n_);
    const Place& at = places_[first + knot];
    if (at.place.size() == 0) return TubePlace::Zero(places_[first + 1].place.size());
    return weights[knot] * at.moves[static_cast<std::size_t>(i % n_)];
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

  // Penalty of a weighted sum of up to three knots from `first` on.
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

  // Joints at a limit with a step outwards are fixed.
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
    if (longest > kMaxStep) change *= kMaxStep / longest;
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
  std::vector<Place> places_;  // of all knots of the present curve; empty without a tube
};

}  // namespace

void refine(const Chain& chain, const std::vector<Knot>& knots, ClearanceTest& test,
            const std::vector<double>& margins, std::vector<JointArray>& q) {
  Refinement(chain, knots, test, margins).run(q);
}

}  // namespace leadthrough::path
