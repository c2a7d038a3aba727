#pragma once

// Skills in a control loop, from the files that `skill.export(path)` writes in Python: the same
// steps as there, to the bit, and none allocates memory. Constructors throw std::invalid_argument
// for another or a damaged file, members for arguments of a wrong size or value.

#include <optional>
#include <string>
#include <vector>

#include "leadthrough/dmp/orientation_curve.hpp"
#include "leadthrough/field/policy.hpp"
#include "leadthrough/learn/basis_functions.hpp"

namespace leadthrough {

class Npz;

// A dynamic movement primitive of points, joints or poses.
class Dmp {
 public:
  explicit Dmp(const std::string& path);

  // Of joints, in the order of the positions; else empty.
  const std::vector<std::string>& joint_names() const { return joint_names_; }
  bool is_of_poses() const { return curve_.has_value(); }
  double duration() const { return demonstrated_duration_; }  // s, as demonstrated

  // Begins a motion that lasts `duration` s; this allocates. start, goal: a point or joints; of
  // poses x, y, z and, unless the orientation is as demonstrated, w, x, y, z. Empty: all is as
  // demonstrated.
  void begin(const Eigen::VectorXd& start, const Eigen::VectorXd& goal, double duration);
  // The state dt s later, dt > 0; it rests at the goal in the end.
  void step(double dt);

  double phase() const { return state_.phase; }  // time over duration
  auto position() const { return state_.value.head(position_size()); }
  auto velocity() const { return state_.slope.head(position_size()) / duration_; }
  // Of poses: w, x, y, z, and rad/s in the base frame.
  so3::Quaternion orientation() const;
  so3::Vector3 angular_velocity() const;

 private:
  Eigen::Index position_size() const { return curve_ ? 3 : state_.value.size(); }
  dmp::Course course(const Eigen::VectorXd& start, const Eigen::VectorXd& goal) const;
  dmp::Path offset(const Eigen::VectorXd& start, const Eigen::VectorXd& goal) const;

  std::vector<std::string> joint_names_;
  double demonstrated_duration_, duration_;
  dmp::Forces forces_;
  dmp::Vector start_, goal_, start_slope_, no_push_;
  dmp::Path demonstrated_, moving_;  // references: as it was, and to be moved by the progress
  Rows progress_;
  std::optional<dmp::Curve> curve_;
  so3::Quaternion first_orientation_, last_orientation_;
  dmp::Course course_;
  dmp::Path offset_;
  dmp::State state_;
};

// The mean motion of a probabilistic movement primitive of points or joints.
class ProMp {
 public:
  explicit ProMp(const std::string& path);

  const std::vector<std::string>& joint_names() const { return joint_names_; }
  double duration() const { return duration_; }  // s; a period of rhythmic motions

  // Position, velocity and acceleration (3, d) at a time, s, until the next call. Before the start
  // and after the end it rests, unless it is rhythmic.
  const Rows& at(double time);

 private:
  explicit ProMp(const Npz& file);

  std::vector<std::string> joint_names_;
  double duration_;
  bool rhythmic_;
  NormalisedBasis basis_;
  Rows weights_;           // (functions, d)
  Eigen::Vector3d paces_;  // of orders: derivatives by the phase to those by time
  Rows values_;
};

// The policy of Fast Marching Learning, for positions in two or three dimensions.
MarchingPolicy load_policy(const std::string& path);

}  // namespace leadthrough
