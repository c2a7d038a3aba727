#include "leadthrough/collision/convex_distance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include "leadthrough/base/constants.hpp"
#include "leadthrough/collision/minkowski.hpp"

namespace leadthrough {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using minkowski::Difference;
using minkowski::Simplex;
using minkowski::Vertex;

constexpr double kTolerance = 1e-10;  // m, between the distance found and the one proven
// Cores nearer than this count as overlapping, m: their direction would be lost in rounding.
constexpr double kCoresTouch = 1e-7;
constexpr int kMaxIterations = 100;

// normal: unit, from a to b; distance: of the cores, below zero where they overlap.
struct NearestOfCores {
  double distance;
  Vector3d normal, on_a, on_b;
};

// Half the length of a point or segment, or nothing.
std::optional<double> half_of_segment(const Convex& body) {
  if (std::holds_alternative<cores::Point>(body.core)) return 0.0;
  if (const auto* segment = std::get_if<cores::Segment>(&body.core)) return segment->half;
  return std::nullopt;
}

NearestOfCores between(const Vector3d& on_a, const Vector3d& on_b) {
  const Vector3d between = on_b - on_a;
  const double distance = between.norm();
  return {distance, between / distance, on_a, on_b};
}

Vector3d perpendicular_to(const Vector3d& direction) {
  Eigen::Index thin = 0;
  direction.cwiseAbs().minCoeff(&thin);
  return direction.cross(Vector3d::Unit(thin)).normalized();
}

// Segments that cross: any direction across both, or across the longer one if they are parallel.
Vector3d direction_across(const Vector3d& a, const Vector3d& b) {
  const Vector3d across = a.cross(b);
  if (across.norm() > 1e-12 * a.norm() * b.norm()) return across.normalized();
  const Vector3d& longer = a.squaredNorm() > b.squaredNorm() ? a : b;
  return longer.isZero() ? Vector3d(Vector3d::UnitX()) : perpendicular_to(longer.normalized());
}

// From the middle of a to that of b; half: from a middle to an end. Ericson 2005, section 5.1.9.
NearestOfCores between_segments(const Vector3d& half_a, const Vector3d& middle_b,
                                const Vector3d& half_b) {
  const auto inside = [](double share) { return std::min(std::max(share, -1.0), 1.0); };
  const double aa = half_a.squaredNorm();
  const double bb = half_b.squaredNorm();
  const double ab = half_a.dot(half_b);
  const double a_way = half_a.dot(middle_b);
  const double b_way = half_b.dot(middle_b);
  const double denominator = aa * bb - ab * ab;
  double s = denominator > 1e-16 * aa * bb ? inside((a_way * bb - b_way * ab) / denominator) : 0.0;
  const double t = bb > 0.0 ? inside((ab * s - b_way) / bb) : 0.0;
  s = aa > 0.0 ? inside((ab * t + a_way) / aa) : 0.0;
  NearestOfCores found = between(s * half_a, middle_b + t * half_b);
  if (found.distance < 1e-12) found.normal = direction_across(half_a, half_b);
  return found;
}

// The squared distance of a point on the segment to the box is convex and piecewise quadratic:
// its derivative is searched for a change of sign, piece by piece.
double nearest_share(const Vector3d& middle, const Vector3d& half, const Vector3d& box) {
  const auto slope = [&](double t) {
    const Vector3d p = middle + t * half;
    return half.dot(p - p.cwiseMax(-box).cwiseMin(box));
  };
  double low = -1.0;
  double high = 1.0;
  double slope_low = slope(low);
  double slope_high = slope(high);
  if (slope_low >= 0.0) return low;
  if (slope_high <= 0.0) return high;
  for (int i = 0; i < 3; ++i) {
    for (const double side : {-box[i], box[i]}) {
      const double t = half[i] != 0.0 ? (side - middle[i]) / half[i] : low;
      if (!(t > low && t < high)) continue;
      const double at = slope(t);
      if (at == 0.0) return t;
      (at < 0.0 ? low : high) = t;
      (at < 0.0 ? slope_low : slope_high) = at;
    }
  }
  return low - slope_low * (high - low) / (slope_high - slope_low);
}

// True if the caller needs the depth of overlapping cores, which takes longer than all the rest,
// and the distance of those that are nearer than the cutoff.
enum class Overlap { kMeasured, kJustSeen };

NearestOfCores overlapping(const Difference& difference, Overlap overlap) {
  if (overlap == Overlap::kJustSeen)
    return {-kInfinity, Vector3d::UnitX(), Vector3d::Zero(), Vector3d::Zero()};
  const minkowski::Depth found = minkowski::penetration(difference);
  return {-found.depth, found.normal, found.on_a, found.on_b};
}

NearestOfCores box_to_segment(const Difference& difference, const Vector3d& box, double half,
                              Overlap overlap) {
  const Vector3d half_b = half * difference.R_a_b.col(2);
  const Vector3d on_b = difference.p_a_b + nearest_share(difference.p_a_b, half_b, box) * half_b;
  const NearestOfCores found = between(on_b.cwiseMax(-box).cwiseMin(box), on_b);
  return found.distance < kCoresTouch ? overlapping(difference, overlap) : found;
}

// Gilbert, Johnson and Keerthi 1988. `nearest` is a point of a - b, `proven` a lower bound on the
// distance by a plane across it. start: from b to a, as far as is known.
NearestOfCores iterate(const Difference& difference, const Vector3d& start, double cutoff,
                       Overlap overlap) {
  Simplex simplex;
  Vector3d nearest = start;
  if (nearest.squaredNorm() < kCoresTouch * kCoresTouch) nearest = Vector3d::UnitX();
  double length = nearest.norm();
  double proven = -kInfinity;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Vertex vertex = difference.farthest(-nearest);
    proven = std::max(proven, nearest.dot(vertex.point) / length);
    if (proven >= cutoff) return {proven, -nearest / length, vertex.on_a, vertex.on_b};
    if (i > 0 && (length - proven <= kTolerance || simplex.has(vertex.point))) break;
    const Simplex before = simplex;
    simplex.add(vertex);
    nearest = simplex.reduce();
    const double shorter = nearest.norm();
    if (simplex.size == 4 || shorter < kCoresTouch) return overlapping(difference, overlap);
    // For a test against the cutoff alone, the exact distance below it is irrelevant.
    if (overlap == Overlap::kJustSeen && shorter < cutoff)
      return {shorter, -nearest / shorter, vertex.on_a, vertex.on_b};
    if (i > 0 && shorter >= length) {  // rounding
      simplex = before;
      break;
    }
    length = shorter;
  }
  return between(minkowski::blend(simplex, simplex.weights, &Vertex::on_a),
                 minkowski::blend(simplex, simplex.weights, &Vertex::on_b));
}

NearestOfCores swapped(const NearestOfCores& nearest, const Difference& from) {
  const auto back = [&](const Vector3d& p) -> Vector3d { return from.R_a_b * p + from.p_a_b; };
  return {nearest.distance, -(from.R_a_b * nearest.normal), back(nearest.on_b), back(nearest.on_a)};
}

NearestOfCores between_cores(const Difference& difference, const Vector3d& start, double cutoff,
                             Overlap overlap) {
  const Convex& a = difference.a;
  const Convex& b = difference.b;
  const auto half_a = half_of_segment(a), half_b = half_of_segment(b);
  if (half_a && half_b)
    return between_segments(*half_a * Vector3d::UnitZ(), difference.p_a_b,
                            *half_b * difference.R_a_b.col(2));
  const auto* box_a = std::get_if<cores::Box>(&a.core);
  if (box_a && half_b) return box_to_segment(difference, box_a->half, *half_b, overlap);
  const auto* box_b = std::get_if<cores::Box>(&b.core);
  if (half_a && box_b) {
    const Matrix3d back = difference.R_a_b.transpose();
    return swapped(
        box_to_segment({b, a, back, -(back * difference.p_a_b)}, box_b->half, *half_a, overlap),
        difference);
  }
  return iterate(difference, start, cutoff, overlap);
}

Difference difference_of(const Convex& a, const Transform& T_base_a, const Convex& b,
                         const Transform& T_base_b) {
  const Matrix3d R_a_base = T_base_a.rotation.transpose();
  return {a, b, R_a_base * T_base_b.rotation, R_a_base * (T_base_b.position - T_base_a.position)};
}

}  // namespace

Separation separation(const Convex& a, const Transform& T_base_a, const Convex& b,
                      const Transform& T_base_b, double cutoff) {
  const Difference difference = difference_of(a, T_base_a, b, T_base_b);
  const double rounding = a.rounding + b.rounding;
  const NearestOfCores cores =
      between_cores(difference, -difference.p_a_b, cutoff + rounding, Overlap::kMeasured);
  const auto to_base = [&](const Vector3d& p) -> Vector3d {
    return T_base_a.rotation * p + T_base_a.position;
  };
  return {cores.distance - rounding, to_base(cores.on_a + a.rounding * cores.normal),
          to_base(cores.on_b - b.rounding * cores.normal), T_base_a.rotation * cores.normal};
}

bool apart(const Convex& a, const Transform& T_base_a, const Convex& b, const Transform& T_base_b,
           double least, Vector3d& normal) {
  const Difference difference = difference_of(a, T_base_a, b, T_base_b);
  const double rounding = a.rounding + b.rounding;
  const NearestOfCores cores = between_cores(difference, -(T_base_a.rotation.transpose() * normal),
                                             least + rounding, Overlap::kJustSeen);
  normal = T_base_a.rotation * cores.normal;
  // The overlap of cores may be within the allowance: touching bodies overlap by rounding.
  if (cores.distance == -kInfinity && least < 0.0)
    return separation(a, T_base_a, b, T_base_b, least).distance >= least;
  return cores.distance - rounding >= least;
}

}  // namespace leadthrough
