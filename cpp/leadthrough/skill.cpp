#include "leadthrough/skill.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/npz.hpp"

namespace leadthrough {

namespace {

constexpr double kMaxSteps = 1000.0;  // durations in a step: more come from a wrong unit

// The file of a kind of skill.
Npz opened(const std::string& path, const std::string& kind) {
  Npz file(path);
  if (!file.has("exported"))
    throw std::invalid_argument(path + ": expected a file of `skill.export` in Python");
  if (const std::string got = file.text("exported"); got != kind)
    throw std::invalid_argument(path + ": expected '" + kind + "', got '" + got +
                                "'; update leadthrough, or load it by the class of its kind");
  return file;
}

std::vector<std::string> joint_names(const Npz& file) {
  std::istringstream lines(file.text("joint_names"));
  std::vector<std::string> result;
  for (std::string line; std::getline(lines, line);) result.push_back(line);
  return result;
}

// The position of a target, or the demonstrated one.
Eigen::VectorXd position_of(const Eigen::VectorXd& target, Eigen::Index size,
                            const dmp::Vector& nominal) {
  dmp::Vector result = nominal;
  if (target.size() > 0) result.head(size) = target.head(size);
  return result;
}

so3::Quaternion orientation_of(const Eigen::VectorXd& target, const so3::Quaternion& nominal) {
  if (target.size() != 7) return nominal;
  const double w = target[3], x = target[4], y = target[5], z = target[6];
  const double length = std::sqrt(w * w + x * x + y * y + z * z);
  check_argument(std::abs(length - 1.0) < 0.01, "start, goal: expected unit quaternions");
  return {w / length, x / length, y / length, z / length};
}

dmp::Curve curve_of(const Npz& file) {
  return {file.rows("controls", 4),
          file.rows("steps", 3),
          file.vector("speeds"),
          file.vector("covered"),
          dmp::Representation::kRotationVector,
          dmp::Canonical::kDiscrete};
}

}  // namespace

Dmp::Dmp(const std::string& path) {
  const Npz file = opened(path, "dmp");
  joint_names_ = leadthrough::joint_names(file);
  demonstrated_duration_ = file.number("duration");
  start_ = file.vector("start");
  goal_ = file.vector("goal");
  start_slope_ = file.vector("start_slope");
  const Eigen::Index channels = start_.size();
  forces_ = {file.rows("nodes", channels), file.vector("fade"), file.number("rate"),
             dmp::Canonical::kDiscrete};
  demonstrated_ = {Eigen::Vector2d(0.0, 1.0), file.rows("demonstrated", channels)};
  moving_ = {file.vector("breaks"), file.rows("moving", channels)};
  progress_ = file.rows("progress", channels);
  no_push_ = dmp::Vector::Zero(channels);
  if (file.has("controls")) {
    curve_ = curve_of(file);
    first_orientation_ = file.vector("start_orientation");
    last_orientation_ = file.vector("goal_orientation");
  }
  const bool fits =
      demonstrated_duration_ > 0.0 && goal_.size() == channels && start_slope_.size() == channels &&
      forces_.nodes.rows() >= 2 && forces_.fade.size() == forces_.nodes.rows() &&
      forces_.rate > 0.0 && demonstrated_.coefficients.rows() == 6 && moving_.breaks.size() >= 2 &&
      moving_.coefficients.rows() == 6 * (moving_.breaks.size() - 1) &&
      progress_.rows() == moving_.coefficients.rows() &&
      (!curve_ || (channels == 6 && curve_->controls.rows() >= 4 &&
                   curve_->steps.rows() == curve_->controls.rows() - 1 &&
                   curve_->speeds.size() >= 2 && curve_->covered.size() == curve_->speeds.size()));
  if (!fits) throw std::invalid_argument(path + ": is damaged");
  begin({}, {}, demonstrated_duration_);
}

void Dmp::begin(const Eigen::VectorXd& start, const Eigen::VectorXd& goal, double duration) {
  check_argument(duration > 0.0 && std::isfinite(duration), "duration: expected seconds > 0");
  for (const Eigen::VectorXd* target : {&start, &goal}) {
    const Eigen::Index size = target->size();
    check_argument(size == 0 || size == (curve_ ? 3 : start_.size()) || (curve_ && size == 7),
                   "start, goal: expected a position, or a position and w, x, y, z of poses");
    check_argument(target->allFinite(), "start, goal: expected finite numbers");
  }
  offset_ = offset(start, goal);
  const Eigen::Index size = curve_ ? 3 : start_.size();
  const dmp::Vector first = position_of(start, size, start_);
  course_ = course(first, position_of(goal, size, goal_));
  state_ = {first, start_slope_, 0.0};
  duration_ = duration;
}

void Dmp::step(double dt) {
  const double span = dt / duration_;
  check_argument(span > 0.0 && span <= kMaxSteps, "dt: expected seconds > 0");
  dmp::advance(forces_, course_, no_push_, span, state_);
}

so3::Quaternion Dmp::orientation() const {
  check_argument(is_of_poses(), "orientation: only of poses");
  return dmp::orientation_at(*curve_, offset_, state_.phase, state_.value.tail<3>());
}

so3::Vector3 Dmp::angular_velocity() const {
  check_argument(is_of_poses(), "angular_velocity: only of poses");
  const dmp::RotationState now = dmp::rotation_at(*curve_, offset_, state_.phase,
                                                  state_.value.tail<3>(), state_.slope.tail<3>());
  return now.velocity / duration_;
}

dmp::Course Dmp::course(const Eigen::VectorXd& start, const Eigen::VectorXd& goal) const {
  const bool is_demonstrated = start == start_ && goal == goal_;
  return {is_demonstrated ? demonstrated_
                          : dmp::shifted(moving_, progress_, start - start_, goal - goal_),
          dmp::Vector::Ones(start_.size()), dmp::Vector::Zero(start_.size())};
}

dmp::Path Dmp::offset(const Eigen::VectorXd& start, const Eigen::VectorXd& goal) const {
  if (!curve_ || (start.size() != 7 && goal.size() != 7)) return {};
  const so3::Vector3 first = dmp::offset_between(orientation_of(start, first_orientation_),
                                                 first_orientation_, so3::Vector3::Zero());
  const so3::Vector3 last =
      dmp::offset_between(orientation_of(goal, last_orientation_), last_orientation_, first);
  if (first.isZero(0.0) && last.isZero(0.0)) return {};
  return dmp::shifted({moving_.breaks, Rows::Zero(progress_.rows(), 3)}, progress_.rightCols(3),
                      first, last);
}

ProMp::ProMp(const std::string& path) : ProMp(opened(path, "promp")) {}

ProMp::ProMp(const Npz& file)
    : joint_names_(leadthrough::joint_names(file)),
      duration_(file.number("duration")),
      rhythmic_(file.number("rhythmic") != 0.0),
      basis_(file.vector("centres"), file.number("sharpness"), rhythmic_),
      weights_(file.rows("weights", static_cast<Eigen::Index>(file.number("columns")))),
      paces_(1.0, std::pow(duration_, -1), std::pow(duration_, -2)),
      values_(3, weights_.cols()) {
  check_argument(duration_ > 0.0 && weights_.rows() == file.vector("centres").size(),
                 "path: expected a skill that is not damaged");
}

const Rows& ProMp::at(double time) {
  check_argument(std::isfinite(time), "time: expected a finite time");
  const double phase = time / duration_;
  const bool moves = rhythmic_ || (phase >= 0.0 && phase <= 1.0);
  const Rows& functions = basis_.at(moves ? phase : std::clamp(phase, 0.0, 1.0), 2);
  values_.setZero();
  for (int order = 0; order <= (moves ? 2 : 0); ++order) {
    const double pace = paces_[order];
    for (Eigen::Index i = 0; i < weights_.rows(); ++i)
      values_.row(order) += (functions(order, i) * pace) * weights_.row(i);
  }
  return values_;
}

MarchingPolicy load_policy(const std::string& path) {
  const Npz file = opened(path, "marching policy");
  const auto arrival = std::make_shared<const std::vector<double>>(file.numbers("arrival"));
  const Eigen::VectorXd shape = file.vector("shape"), goal = file.vector("goal");
  if (shape.prod() != static_cast<double>(arrival->size()))
    throw std::invalid_argument(path + ": is damaged");
  std::optional<StartBarrier> barrier;
  if (file.has("barrier_middle"))
    barrier = {file.vector("barrier_middle"), file.vector("barrier_normal"),
               file.number("barrier_width"), file.number("barrier_thickness")};
  return MarchingPolicy({shape, file.vector("spacing"), file.vector("origin"), arrival->data(),
                         arrival, goal, file.rows("positions", goal.size()), file.vector("speeds"),
                         file.number("mean_speed"), file.number("slowing"), barrier});
}

}  // namespace leadthrough
