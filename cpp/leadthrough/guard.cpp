#include "leadthrough/guard.hpp"

#include <utility>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/guard/brake.hpp"
#include "leadthrough/guard/path_curve.hpp"

namespace leadthrough {

Guard::Guard(const Arm& arm, guard::StepLimits limits, const std::vector<Shape>& obstacles,
             const GuardMargins& margins)
    : limits_(std::move(limits)),
      scene_(guard::guarded_scene(arm.collision_model(), placed_shapes(obstacles),
                                  std::vector<double>(obstacles.size(), 0.0), margins.obstacles,
                                  margins.itself)) {
  guard::check_limits(limits_);
  check_argument(limits_.joints() == arm.chain().joints(), "limits: expected those of the arm");
  start(middle(arm.chain()));
}

void Guard::start(const Joints& q) {
  check_argument(q.size() == limits_.joints() && q.allFinite(), "q: expected the arm's joints");
  stream_ = Rows::Zero(1, 3 * q.size());
  stream_.leftCols(q.size()) = q.transpose();
  at_ = 0;
}

bool Guard::admit(const Arm::Path& positions) {
  const Eigen::Index count = positions.rows(), joints = limits_.joints();
  check_argument(count > 0 && positions.cols() == joints, "positions: expected the arm's joints");
  if (!positions.allFinite()) return false;
  const Rows now = stream_.row(at_);
  const Eigen::VectorXd times =
      limits_.period * Eigen::VectorXd::LinSpaced(count, 0.0, static_cast<double>(count - 1));
  const Rows rows = guard::with_rates(times, positions, now, limits_.period);
  if (guard::first_excess(limits_, now, rows)) return false;
  const Rows stop = guard::brake(limits_, rows.bottomRows(1));
  if (guard::first_excess(limits_, rows.bottomRows(1), stop)) return false;
  Rows stream(1 + count + stop.rows(), 3 * joints);
  stream << now, rows, stop;
  if (guard::first_contact(scene_, now.row(0).head(joints).transpose(),
                           stream.bottomRows(count + stop.rows()).leftCols(joints), 0.0))
    return false;
  stream_ = std::move(stream);
  at_ = 0;
  return true;
}

void Guard::next() {
  if (remaining() > 0) ++at_;
}

}  // namespace leadthrough
