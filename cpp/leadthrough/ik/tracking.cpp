#include "leadthrough/ik/tracking.hpp"

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/ik/axis_task.hpp"
#include "leadthrough/ik/pose_descent.hpp"

namespace leadthrough {

namespace {

struct Preference {
  JointArray posture;
  double share;  // of the distance to the posture
};

bool reached(const DescentEnd& end, const IkTolerance& tolerance) {
  return end.position_error <= tolerance.position && end.orientation_error <= tolerance.orientation;
}

template <int M, typename Target>
DescentEnd follow_sample(const Chain& chain, const Target& target, const Preference& preferred,
                         const TrackOptions& options, JointArray& q) {
  // Near a singularity the last digits cost most: they are attempted, not required.
  constexpr double kAim = 0.1;
  const IkTolerance aim{kAim * options.tolerance.position, kAim * options.tolerance.orientation};
  const JointBox bounds = around(q, options.max_step, position_limits(chain), chain.joints());
  const bool pulls = preferred.share > 0.0 && chain.joints() > constrained_rows<M>(target);
  DescentEnd end;
  for (const bool pulled : {true, false}) {  // without the pull if it prevents convergence
    if (pulled && !pulls) continue;
    PoseDescent<M, Target> descent(chain, target, bounds, q);
    if (pulled) descent.pull(pull_to(preferred.posture, chain.joints(), q, preferred.share));
    end = descent.run(aim, options.max_iterations);
    if (pulled && !reached(end, options.tolerance)) continue;
    q = descent.q();
    break;
  }
  return end;
}

}  // namespace

void Track::keep(Eigen::Index samples) {
  q.conservativeResize(samples, Eigen::NoChange);
  position_errors.conservativeResize(samples);
  orientation_errors.conservativeResize(samples);
}

void check_path(Eigen::Index samples, const Rows4Ref& orientations, const Pull& pull,
                const Chain& chain) {
  check_argument(orientations.rows() == samples || orientations.rows() == 0,
                 "orientations: expected a row for each position, or none");
  check_argument(pull.postures.rows() == samples && pull.postures.cols() == chain.joints() &&
                     pull.shares.size() == samples,
                 "pull: expected a row for each position and one value a joint");
}

Track track(const Chain& chain, const Rows3Ref& positions, const Rows4Ref& orientations,
            const VectorRef& start, const Pull& pull, const TrackOptions& options) {
  const Eigen::Index samples = positions.rows();
  check_path(samples, orientations, pull, chain);
  Track result{Rows(samples, chain.joints()), Eigen::VectorXd(samples), Eigen::VectorXd(samples)};
  const JointVector inside = project(chain, start);
  JointArray q{};
  std::copy(inside.data(), inside.data() + inside.size(), q.begin());
  for (Eigen::Index k = 0; k < samples; ++k) {
    check_interrupt();
    Preference preferred{{}, pull.shares[k]};
    std::copy_n(pull.postures.row(k).data(), chain.joints(), preferred.posture.begin());
    const IkTarget pose = target_in_row(positions, orientations, k);
    const DescentEnd end =
        visit_target(pose, options.axes, [&](auto dimension, const auto& target) {
          return follow_sample<decltype(dimension)::value>(chain, target, preferred, options, q);
        });
    std::copy(q.begin(), q.begin() + chain.joints(), result.q.row(k).data());
    result.position_errors[k] = end.position_error;
    result.orientation_errors[k] = end.orientation_error;
    if (!reached(end, options.tolerance)) {
      result.keep(k + 1);
      break;
    }
  }
  return result;
}

}  // namespace leadthrough
