#include "leadthrough/learn/sample_truncated_gaussian.hpp"

#include <algorithm>
#include <cmath>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/constants.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough {
namespace {

// In a corner a particle could be reflected without end; it is inside at every reflection.
constexpr int kMaxBounces = 1000;

// The time at which a cos t + b sin t next rises to `limit`, or `horizon` if it does not before.
double reached(double a, double b, double limit, double horizon) {
  const double squared = a * a + b * b;
  if (limit > 0.0 && squared <= limit * limit) return horizon;
  if (a >= limit && b > 0.0) return 0.0;  // on the wall, to rounding, and moving into it
  const double amplitude = std::sqrt(squared);
  const double ratio = limit / amplitude;
  if (!(ratio >= -1.0)) return horizon;
  double time = std::atan2(b, a) - std::acos(std::min(ratio, 1.0));
  if (time < 0.0) time += kTurn;
  return std::min(time, horizon);
}

// A particle of unit mass on a unit spring. `height` and `rise`: its position and velocity along
// the walls' normals.
struct Particle {
  Eigen::VectorXd position;
  Eigen::VectorXd velocity;
  Eigen::VectorXd height;
  Eigen::VectorXd rise;

  void advance(double time) {
    const double c = std::cos(time);
    const double s = std::sin(time);
    turn(position, velocity, c, s);
    turn(height, rise, c, s);
  }

 private:
  static void turn(Eigen::VectorXd& at, Eigen::VectorXd& moving, double c, double s) {
    for (Eigen::Index i = 0; i < at.size(); ++i) {
      const double before = at[i];
      at[i] = c * before + s * moving[i];
      moving[i] = c * moving[i] - s * before;
    }
  }
};

void travel(Particle& particle, const RowsRef& walls, const VectorRef& limits,
            const Eigen::VectorXd& lengths) {
  double left = 0.5 * kPi;
  for (int bounce = 0; bounce < kMaxBounces; ++bounce) {
    check_interrupt();
    double time = left;
    Eigen::Index hit = -1;
    for (Eigen::Index i = 0; i < walls.rows(); ++i) {
      const double at = reached(particle.height[i], particle.rise[i], limits[i], time);
      if (at < time) {
        time = at;
        hit = i;
      }
    }
    particle.advance(time);
    if (hit < 0) return;
    left -= time;
    particle.velocity -= 2.0 * particle.rise[hit] / lengths[hit] * walls.row(hit).transpose();
    particle.rise.noalias() = walls * particle.velocity;
  }
}

}  // namespace

Rows sample_truncated_gaussian(const RowsRef& walls, const VectorRef& limits,
                               const VectorRef& start, const RowsRef& velocities) {
  check_argument(limits.size() == walls.rows() && start.size() == walls.cols() &&
                     velocities.cols() == walls.cols(),
                 "limits, start, velocities: expected the sizes of walls");
  check_argument((walls.rowwise().squaredNorm().array() > 0.0).all(), "walls: expected directions");
  const Eigen::VectorXd lengths = walls.rowwise().squaredNorm();
  Rows drawn(velocities.rows(), velocities.cols());
  Particle particle{start, start, walls * start, limits};
  for (Eigen::Index i = 0; i < velocities.rows(); ++i) {
    check_interrupt();
    particle.velocity = velocities.row(i);
    particle.height.noalias() = walls * particle.position;
    particle.rise.noalias() = walls * particle.velocity;
    travel(particle, walls, limits, lengths);
    drawn.row(i) = particle.position;
  }
  return drawn;
}

}  // namespace leadthrough
