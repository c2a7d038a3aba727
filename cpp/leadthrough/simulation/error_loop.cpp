#include "leadthrough/simulation/error_loop.hpp"

#include <cmath>
#include <utility>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough::simulation {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kMoving = 1e-6;   // rad/s (m/s): slower, dry friction is that of the last way
constexpr double kDiverged = 1e3;  // rad, rad/s (m, m/s)

void check(const ErrorPiece& piece, Index n, Index every) {
  const Index count = piece.left.rows();
  check_argument(piece.ease.cols() == n * n && piece.answer.cols() == 2 * n * n,
                 "ease and answer: matrices of the joints");
  for (const auto* each : {&piece.ease, &piece.answer})
    check_argument(each->rows() * every >= count, "ease and answer: for all samples");
  for (const auto* each : {&piece.left, &piece.q, &piece.qd, &piece.qdd})
    check_argument(each->rows() == count && each->cols() == n, "motion: rows (n, joints)");
}

}  // namespace

ErrorLoop::ErrorLoop(ErrorModel model, const VectorXd& speed) : model_(std::move(model)) {
  const Index n = speed.size();
  check_argument(n > 0 && model_.dampers.size() == n && model_.friction.size() == n,
                 "dampers and friction: one value a joint");
  check_argument(model_.every > 0 && model_.steps > 0, "every and steps: above 0");
  check_argument(model_.late >= 0 && model_.late < 100'000, "late: 0 to 100000 periods");
  planned_ = Rows::Zero(model_.late + 1, 2 * n);
  const VectorXd none = VectorXd::Zero(n);
  smooth_ = {planned_, VectorXd::Zero(2 * n), speed, none};
  dry_ = {planned_, VectorXd::Zero(2 * n), none, none};
  direction_ = qdd_ = left_ = held_ = total_ = damped_ = slowed_ = none;
  moved_ = VectorXd::Zero(2 * n);
}

Rows ErrorLoop::advance(const ErrorPiece& piece) {
  const Index n = direction_.size(), count = piece.left.rows();
  check(piece, n, model_.every);
  const double shift = 0.5 * (model_.period - model_.period / model_.steps);
  Rows errors = Rows::Zero(count, n);
  for (Index row = 0; row < count && diverged_ < 0; ++row, ++k_) {
    check_interrupt(row);
    const Index at = row / model_.every, own = k_ % planned_.rows();
    // Before the first late measurement there is the first one.
    delayed_ = k_ < model_.late ? 0 : (k_ + 1) % planned_.rows();
    planned_.row(own) << piece.q.row(row), piece.qd.row(row);
    moved_ = planned_.row(own) - planned_.row(delayed_);
    for (Index i = 0; i < n; ++i) {
      const double speed = piece.qd(row, i);
      if (std::abs(speed) > kMoving) direction_[i] = speed > 0.0 ? 1.0 : -1.0;
    }
    // The planned velocity jumps at samples, between which its derivative is constant.
    smooth_.speed += shift * (piece.qdd.row(row).transpose() - qdd_);
    qdd_ = piece.qdd.row(row);
    errors.row(row) = smooth_.now.head(n) + dry_.now.head(n);
    const Matrix ease(piece.ease.row(at).data(), n, n);
    const Matrix answer(piece.answer.row(at).data(), n, 2 * n);
    left_ = piece.left.row(row);
    advance(smooth_, ease, answer, left_, moved_);
    left_ = model_.friction.cwiseProduct(direction_);
    moved_.setZero();
    advance(dry_, ease, answer, left_, moved_);
  }
  return errors;
}

void ErrorLoop::advance(Response& response, const Matrix& ease, const Matrix& answer,
                        const Vector& left, const Vector& moved) {
  const Index n = left.size();
  auto& [late, now, speed, largest] = response;
  largest = largest.cwiseMax(now.head(n).cwiseAbs());
  late.row(k_ % late.rows()) = now;
  now = late.row(delayed_).transpose() + moved;
  held_.noalias() = ease * left;
  held_.noalias() -= answer * now;
  now.head(n) = late.row(k_ % late.rows()).head(n);
  total_.setZero();
  for (int i = 0; i < model_.steps; ++i) {
    damped_ = model_.dampers.cwiseProduct(speed);
    slowed_.noalias() = ease * damped_;
    speed += model_.period / model_.steps * (held_ - slowed_);
    total_ += speed;
  }
  now.tail(n) = total_ / model_.steps;
  now.head(n) += model_.period * now.tail(n);
  if (k_ % model_.every != 0 || (now.array().abs() < kDiverged).all()) return;
  now.cwiseAbs().maxCoeff<Eigen::PropagateNaN>(&diverged_);
  diverged_ %= n;
}

}  // namespace leadthrough::simulation
