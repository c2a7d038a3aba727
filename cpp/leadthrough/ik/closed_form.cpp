#include "leadthrough/ik/closed_form.hpp"

#include "leadthrough/ik/general_shoulder.hpp"

namespace leadthrough {

namespace {

// The sine of an angle below which the plane of two vectors is not known.
constexpr double kParallel = 1e-12;

Eigen::Vector3d moved(const Transform& T, const Eigen::Vector3d& point) {
  return T.rotation * point + T.position;
}

// The inverse of a rotation about an axis.
Transform undoing(const Screw& screw, Angle angle) {
  const Eigen::Matrix3d R = rotation_about(screw.axis, opposite(angle));
  return {R, screw.point - R * screw.point};
}

// The shortest rotation of a onto b, of the same length.
Eigen::Matrix3d shortest_turn(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d cross = a.cross(b);
  const bool parallel = cross.norm() <= kParallel * b.squaredNorm();
  const Eigen::Vector3d axis = parallel ? a.unitOrthogonal() : cross.normalized();
  return rotation_about(axis, angle_between(axis, a, b));
}

class Pass {
 public:
  Pass(const ClosedForm& form, double parameter, Walk& walk, Candidates& found)
      : form_(form), parameter_(parameter), walk_(walk), found_(found) {}

  void run(const Transform& T_base_tip) {
    goal_ = T_base_tip * form_.T_tip_base;
    const Angle given{std::cos(parameter_), std::sin(parameter_)};
    if (form_.parameter == Parameter::kLastJoint) goal_ = goal_ * undoing(form_.given, given);
    if (form_.parameter == Parameter::kFirstJoint) goal_ = undoing(form_.given, given) * goal_;
    if (form_.reversed) goal_ = inverse(goal_);
    if (form_.structure == Structure::kThreeParallel) return three_parallel();
    if (form_.structure == Structure::kTwoSpheres) return two_spheres(given);
    spherical_wrist();
  }

 private:
  const Eigen::Vector3d& axis(std::size_t k) const { return form_.screws[k].axis; }
  const Eigen::Vector3d& point(std::size_t k) const { return form_.screws[k].point; }

  Eigen::Vector3d turn(std::size_t k, const Eigen::Vector3d& x) const {
    return rotate(axis(k), q_[k], x - point(k)) + point(k);
  }
  Eigen::Matrix3d rotation(std::size_t k) const { return rotation_about(axis(k), q_[k]); }

  // Joint k from what the joints around it leave of a rotation.
  void take_rest(std::size_t k, const Eigen::Vector3d& across_turned) {
    q_[k] = angle_between(axis(k), form_.across[k], across_turned);
  }

  // Joint k brings x to a distance from a centre, both in the base frame.
  template <typename Visit>
  void each_distance(std::size_t k, const Eigen::Vector3d& x, const Eigen::Vector3d& centre,
                     double squared_distance, const Visit& visit) {
    const Eigen::Vector3d from = x - point(k), to = centre - point(k);
    const double constant = axis(k).dot(from) * axis(k).dot(to);
    const double middle = 0.5 * (from.squaredNorm() + to.squaredNorm() - squared_distance);
    const double scale = 1.0 / to.norm();
    each_angle(scale * (to.dot(from) - constant), scale * to.dot(axis(k).cross(from)),
               scale * (middle - constant), walk_, [&](Angle angle) {
                 q_[k] = angle;
                 visit();
               });
  }

  // Joints i and i + 1, whose axes are parallel, bring x to a point.
  template <typename Visit>
  void each_planar_pair(std::size_t i, const Eigen::Vector3d& x, const Eigen::Vector3d& goal,
                        const Visit& visit) {
    // In the plane of x, so that what an arm lacks in parallelism makes no distance.
    const Eigen::Vector3d& h = axis(i + 1);
    const Eigen::Vector3d centre = point(i) + h * h.dot(x - point(i));
    const Eigen::Vector3d from_centre = goal - point(i);
    const double squared = from_centre.squaredNorm() - std::pow(h.dot(from_centre), 2);
    each_distance(i + 1, x, centre, squared, [&] {
      each_rotation(axis(i), turn(i + 1, x) - point(i), from_centre, walk_, [&](Angle angle) {
        q_[i] = angle;
        visit();
      });
    });
  }

  // Joints k to k + 2, whose axes meet, make a rotation.
  template <typename Visit>
  void each_spherical(std::size_t k, const Eigen::Matrix3d& R, const Visit& visit) {
    const Eigen::Vector3d last = R * axis(k + 2);
    each_projection(axis(k + 1), axis(k + 2), axis(k), axis(k).dot(last), walk_, [&](Angle angle) {
      q_[k + 1] = angle;
      const Eigen::Vector3d before = rotate(axis(k + 1), angle, axis(k + 2));
      each_rotation(axis(k), before, last, walk_, [&](Angle first) {
        q_[k] = first;
        take_rest(k + 2, rotate(axis(k + 1), opposite(angle),
                                rotate(axis(k), opposite(first), R * form_.across[k + 2])));
        visit();
      });
    });
  }

  void three_parallel() {
    const Eigen::Vector3d& h = axis(1);
    const Eigen::Vector3d wrist = moved(goal_, form_.wrist);
    each_projection(axis(0), h, wrist - point(0), h.dot(form_.wrist - point(0)), walk_,
                    [&](Angle angle) {
                      q_[0] = angle;
                      const Transform rest = undoing(form_.screws[0], angle) * goal_;
                      three_parallel_after_first(rest, moved(rest, form_.wrist));
                    });
  }

  void three_parallel_after_first(const Transform& rest, const Eigen::Vector3d& wrist) {
    const Eigen::Vector3d& h = axis(1);
    const auto planar = [&](Angle angle) {
      q_[5] = angle;
      const Eigen::Matrix3d R = rest.rotation * (rotation(4) * rotation(5)).transpose();
      const Eigen::Vector3d goal = R * (point(3) - form_.wrist) + wrist;
      each_planar_pair(1, point(3), goal, [&] {
        take_rest(
            3, rotate(axis(2), opposite(q_[2]), rotate(h, opposite(q_[1]), R * form_.across[3])));
        add();
      });
    };
    const Eigen::Vector3d normal = rest.rotation.transpose() * h;
    each_projection(axis(4), axis(5), h, normal.dot(axis(5)), walk_, [&](Angle angle) {
      q_[4] = angle;
      each_rotation(axis(5), normal, rotate(axis(4), opposite(angle), h), walk_, planar);
    });
  }

  void spherical_wrist() {
    const Eigen::Vector3d goal = moved(goal_, form_.wrist);
    if (form_.shoulder == Shoulder::kParallel23) return parallel_23(goal);
    if (form_.shoulder == Shoulder::kMeeting12) return meeting_12(goal);
    if (form_.shoulder == Shoulder::kParallel12) return parallel_12(goal);
    each_general_shoulder(form_.screws, form_.wrist, goal, walk_, [&](const auto& angles) {
      std::copy(angles.begin(), angles.end(), q_.begin());
      orient();
    });
  }

  void parallel_23(const Eigen::Vector3d& goal) {
    const Eigen::Vector3d from_first = goal - point(0);
    const double height = axis(1).dot(form_.wrist - point(0));
    each_projection(axis(0), axis(1), from_first, height, walk_, [&](Angle angle) {
      q_[0] = angle;
      const Eigen::Vector3d in_plane = rotate(axis(0), opposite(angle), from_first) + point(0);
      each_planar_pair(1, form_.wrist, in_plane, [&] { orient(); });
    });
  }

  void meeting_12(const Eigen::Vector3d& goal) {
    const Eigen::Vector3d to = goal - form_.meeting;
    each_distance(2, form_.wrist, form_.meeting, to.squaredNorm(), [&] {
      const Eigen::Vector3d from = turn(2, form_.wrist) - form_.meeting;
      each_projection(axis(1), from, axis(0), axis(0).dot(to), walk_, [&](Angle angle) {
        q_[1] = angle;
        each_rotation(axis(0), rotate(axis(1), angle, from), to, walk_, [&](Angle first) {
          q_[0] = first;
          orient();
        });
      });
    });
  }

  void parallel_12(const Eigen::Vector3d& goal) {
    const double height = axis(0).dot(goal - point(2));
    each_projection(axis(2), form_.wrist - point(2), axis(0), height, walk_, [&](Angle angle) {
      q_[2] = angle;
      each_planar_pair(0, turn(2, form_.wrist), goal, [&] { orient(); });
    });
  }

  void orient() {
    const Eigen::Matrix3d R = rotation(0) * rotation(1) * rotation(2);
    each_spherical(3, R.transpose() * goal_.rotation, [&] { add(); });
  }

  // The elbow's angle is that from the shortest rotation of shoulder to wrist.
  void two_spheres(Angle elbow) {
    const Eigen::Vector3d to = moved(goal_, form_.wrist) - form_.meeting;
    each_distance(3, form_.wrist, form_.meeting, to.squaredNorm(), [&] {
      const Eigen::Vector3d from = turn(3, form_.wrist) - form_.meeting;
      const Eigen::Matrix3d R = rotation_about(to.normalized(), elbow) * shortest_turn(from, to);
      each_spherical(0, R, [&] {
        const Eigen::Matrix3d rest = (R * rotation(3)).transpose() * goal_.rotation;
        each_spherical(4, rest, [&] { add(); });
      });
    });
  }

  void add() {
    if (walk_.depth != walk_.given || found_.count == static_cast<int>(found_.at.size())) return;
    Candidate& candidate = found_.at[static_cast<std::size_t>(found_.count++)];
    candidate.branch = walk_.branch;
    candidate.missed = walk_.missed;
    const bool whole = form_.structure == Structure::kTwoSpheres;
    const std::size_t first = form_.parameter == Parameter::kFirstJoint ? 1 : 0;
    for (std::size_t k = 0; k < (whole ? 7U : 6U); ++k) {
      const double angle = std::atan2(q_[k].sine, q_[k].cosine);
      candidate.q[first + (form_.reversed ? 5 - k : k)] = form_.reversed ? -angle : angle;
    }
    if (form_.parameter == Parameter::kFirstJoint) candidate.q[0] = parameter_;
    if (form_.parameter == Parameter::kLastJoint) candidate.q[6] = parameter_;
  }

  const ClosedForm& form_;
  double parameter_;
  Walk& walk_;
  Candidates& found_;
  Transform goal_;
  std::array<Angle, 7> q_;
};

}  // namespace

void solve(const ClosedForm& form, const Transform& T_base_tip, double parameter, Walk& walk,
           Candidates& found) {
  Pass(form, parameter, walk, found).run(T_base_tip);
}

}  // namespace leadthrough
