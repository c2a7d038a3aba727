// The structure of an arm, from its axes at zero.

#include "leadthrough/ik/closed_form.hpp"

namespace leadthrough {

namespace {

// Ranges of deviations, rad and m: none; angles and lengths with few digits; calibrated arms.
constexpr std::array<double, 3> kDeviations{1e-9, 1e-4, 1e-2};
// Axes at smaller angles (sine) or levers (m) make no well-conditioned structure.
constexpr double kMinAngle = 0.05, kMinLever = 0.01;

using Screws = std::array<Screw, 7>;

double sine_between(const Screw& a, const Screw& b) { return a.axis.cross(b.axis).norm(); }
bool crossing(const Screw& a, const Screw& b) { return sine_between(a, b) > kMinAngle; }

double distance_to(const Screw& screw, const Eigen::Vector3d& point) {
  return screw.axis.cross(point - screw.point).norm();
}
bool has_lever(const Screw& screw, const Eigen::Vector3d& point) {
  return distance_to(screw, point) > kMinLever;
}

// Snaps an arm to a structure and measures by how much.
class Snap {
 public:
  Snap(ClosedForm& form, double tolerance) : form_(form), tolerance_(tolerance) {}

  // Axes that are parallel, or antiparallel, get one direction.
  bool parallel(std::size_t first, std::size_t count) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t k = first; k < first + count; ++k) sum += side(first, k) * at(k).axis;
    sum.normalize();
    for (std::size_t k = first; k < first + count; ++k) {
      if (!take(at(k).axis.cross(sum).norm())) return false;
      at(k).axis = side(first, k) * sum;
    }
    return true;
  }

  // Axes that meet get one point.
  bool meeting(std::size_t first, std::size_t count, Eigen::Vector3d& point) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t k = first; k < first + count; ++k) {
      if (k > first && !crossing(at(k - 1), at(k))) return false;
      const Eigen::Matrix3d across =
          Eigen::Matrix3d::Identity() - at(k).axis * at(k).axis.transpose();
      sum += across;
      right += across * at(k).point;
    }
    point = sum.ldlt().solve(right);
    for (std::size_t k = first; k < first + count; ++k) {
      if (!take(distance_to(at(k), point))) return false;
      at(k).point = point;
    }
    return true;
  }

 private:
  Screw& at(std::size_t k) { return form_.screws[k]; }
  double side(std::size_t first, std::size_t k) {
    return at(first).axis.dot(at(k).axis) < 0.0 ? -1.0 : 1.0;
  }
  bool take(double deviation) {
    form_.deviation = std::max(form_.deviation, deviation);
    return deviation <= tolerance_;
  }

  ClosedForm& form_;
  double tolerance_;
};

bool is_three_parallel(ClosedForm& form, double tolerance) {
  form.structure = Structure::kThreeParallel;
  Snap snap(form, tolerance);
  const Screws& s = form.screws;
  return snap.parallel(1, 3) && snap.meeting(4, 2, form.wrist) && crossing(s[0], s[1]) &&
         crossing(s[3], s[4]) && has_lever(s[1], s[2].point) && has_lever(s[2], s[3].point);
}

bool is_spherical_wrist(ClosedForm& form, double tolerance) {
  form.structure = Structure::kSphericalWrist;
  if (!Snap(form, tolerance).meeting(3, 3, form.wrist)) return false;
  const Screws& s = form.screws;
  if (!has_lever(s[2], form.wrist)) return false;
  const ClosedForm snapped = form;
  form.shoulder = Shoulder::kParallel23;
  if (Snap(form, tolerance).parallel(1, 2))
    return crossing(s[0], s[1]) && has_lever(s[1], s[2].point);
  form = snapped;
  form.shoulder = Shoulder::kMeeting12;
  if (Snap(form, tolerance).meeting(0, 2, form.meeting))
    return has_lever(s[2], form.meeting) && crossing(s[1], s[2]);
  form = snapped;
  form.shoulder = Shoulder::kParallel12;
  if (Snap(form, tolerance).parallel(0, 2))
    return crossing(s[1], s[2]) && has_lever(s[0], s[1].point);
  form = snapped;
  form.shoulder = Shoulder::kGeneral;
  constexpr double kSkew = kDeviations.back();  // nearer ones are one of the above
  const Eigen::Vector3d along = s[0].axis.cross(s[1].axis);
  return crossing(s[0], s[1]) && crossing(s[1], s[2]) &&
         std::abs(along.dot(s[1].point - s[0].point)) > kSkew * along.norm();
}

bool is_two_spheres(ClosedForm& form, double tolerance) {
  form.structure = Structure::kTwoSpheres;
  form.parameter = Parameter::kElbow;
  Snap snap(form, tolerance);
  return snap.meeting(0, 3, form.meeting) && snap.meeting(4, 3, form.wrist) &&
         has_lever(form.screws[3], form.meeting) && has_lever(form.screws[3], form.wrist);
}

bool has_six(ClosedForm& form, const Screw* screws, double tolerance) {
  for (const bool reversed : {false, true}) {
    form.reversed = reversed;
    for (const auto& matches : {is_three_parallel, is_spherical_wrist}) {
      for (std::size_t k = 0; k < 6; ++k) form.screws[k] = screws[reversed ? 5 - k : k];
      form.deviation = 0.0;
      if (matches(form, tolerance)) return true;
    }
  }
  return false;
}

bool has_seven(ClosedForm& form, const Screws& screws, double tolerance) {
  form.screws = screws;
  form.deviation = 0.0;
  form.reversed = false;
  if (is_two_spheres(form, tolerance)) return true;
  form.parameter = Parameter::kLastJoint;
  form.given = screws[6];
  if (has_six(form, screws.data(), tolerance)) return true;
  form.parameter = Parameter::kFirstJoint;
  form.given = screws[0];
  return has_six(form, screws.data() + 1, tolerance);
}

// T_base_tip at zero, and the axes.
Transform zero_configuration(const Chain& chain, Screws& screws) {
  Transform T = chain.fixed[0];
  for (std::size_t k = 0; k < static_cast<std::size_t>(chain.moving); ++k) {
    screws[k] = {T.rotation.col(2), T.position};
    T = T * chain.fixed[k + 1];
  }
  return T;
}

bool is_plain(const Chain& chain) {
  const auto last = chain.prismatic.begin() + chain.moving;
  return (chain.moving == 6 || chain.moving == 7) && !chain.mimics &&
         std::none_of(chain.prismatic.begin(), last, [](bool slides) { return slides; });
}

}  // namespace

std::optional<ClosedForm> recognize(const Chain& chain) {
  if (!is_plain(chain)) return std::nullopt;
  Screws screws;
  ClosedForm form;
  form.T_tip_base = inverse(zero_configuration(chain, screws));
  const bool six = chain.moving == 6;
  for (const double tolerance : kDeviations) {
    if (!(six ? has_six(form, screws.data(), tolerance) : has_seven(form, screws, tolerance)))
      continue;
    for (std::size_t k = 0; k < screws.size(); ++k)
      form.across[k] = form.screws[k].axis.unitOrthogonal();
    return form;
  }
  return std::nullopt;
}

}  // namespace leadthrough
