#pragma once

// The linear theory of a controller's errors along a motion: M e'' + D e' + K e = u, with matrices
// that change on the way.

#include <Eigen/Core>

#include "leadthrough/base/matrix.hpp"

namespace leadthrough::simulation {

// One value a joint each.
struct ErrorModel {
  Eigen::VectorXd dampers;   // that act at once, N m s/rad (N s/m)
  Eigen::VectorXd friction;  // dry, N m (N)
  double period = 1e-3;      // s
  int steps = 1;             // of the physics in a period
  Eigen::Index late = 0;     // periods by which the controller's measurements are delayed
  Eigen::Index every = 1;    // samples that share matrices
};

// A piece of a motion: rows of `every` samples, then of each one.
struct ErrorPiece {
  using Part = RowsRef;

  const Part& ease;          // M^-1 (joints, joints) in a row
  const Part& answer;        // M^-1 K and M^-1 D of the controller (joints, 2 joints) in a row
  const Part& left;          // torques (n, joints) that the controller leaves to the error
  const Part &q, &qd, &qdd;  // planned (n, joints)
};

class ErrorLoop {
 public:
  // speed: of the errors at the beginning (joints,).
  ErrorLoop(ErrorModel model, const Eigen::VectorXd& speed);

  // Errors (n, joints) along the next piece; if one diverges, zeros from there on.
  Rows advance(const ErrorPiece& piece);

  const Eigen::VectorXd& smooth() const { return smooth_.largest; }  // without dry friction
  const Eigen::VectorXd& dry() const { return dry_.largest; }        // by dry friction alone
  Eigen::Index diverged() const { return diverged_; }                // the first joint, or -1

 private:
  struct Response {
    Rows late;              // errors and rates, of sample k in row k % rows
    Eigen::VectorXd now;    // of this sample
    Eigen::VectorXd speed;  // at this moment; the controller sees a period's mean
    Eigen::VectorXd largest;
  };
  using Vector = VectorRef;
  using Matrix = Eigen::Map<const Rows>;

  void advance(Response& response, const Matrix& ease, const Matrix& answer, const Vector& left,
               const Vector& moved);

  ErrorModel model_;
  Response smooth_, dry_;
  Rows planned_;  // positions and velocities, of sample k in row k % rows
  Eigen::VectorXd direction_, qdd_, left_, moved_, held_, total_, damped_, slowed_;
  Eigen::Index k_ = 0, delayed_ = 0, diverged_ = -1;
};

}  // namespace leadthrough::simulation
