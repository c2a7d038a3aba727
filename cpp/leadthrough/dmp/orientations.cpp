// Orientations at many phases, four at a time: each is a long chain of operations that wait for one
// another, four chains wait together. The operations on each are those of a single orientation, in
// their order, so that the numbers are the same.

#include <algorithm>
#include <array>
#include <cmath>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"
#include "leadthrough/dmp/orientation_curve.hpp"
#include "leadthrough/dmp/orientation_curve_parts.hpp"

namespace leadthrough::dmp {

namespace {

using Eigen::Index;
using so3::Quaternion;
using so3::Vector3;

constexpr Index kLanes = 4;
using Lanes = Eigen::Array<double, kLanes, 1>;

// First number of each lane.
using Places = std::array<const double*, kLanes>;

// The k-th numbers of all lanes, combined in registers: loading numbers together right after
// storing them one by one stalls.
Lanes taken(const Places& places, Index k) {
  return {places[0][k], places[1][k], places[2][k], places[3][k]};
}

struct Vectors4 {
  Lanes x, y, z;

  // One per length.
  Lanes quarter_squared() const { return 0.25 * (x * x + y * y + z * z); }
};

Vectors4 vectors_at(const Places& places) {
  return {taken(places, 0), taken(places, 1), taken(places, 2)};
}

struct Quaternions4 {
  Lanes w, x, y, z;

  Quaternion get(Index lane) const { return {w[lane], x[lane], y[lane], z[lane]}; }
};

Quaternions4 quaternions_at(const Places& places) {
  return {taken(places, 0), taken(places, 1), taken(places, 2), taken(places, 3)};
}

Quaternions4 compose(const Quaternions4& a, const Quaternions4& b) {
  return {a.w * b.w - (a.x * b.x + a.y * b.y + a.z * b.z),
          a.w * b.x + b.w * a.x + (a.y * b.z - a.z * b.y),
          a.w * b.y + b.w * a.y + (a.z * b.x - a.x * b.z),
          a.w * b.z + b.w * a.z + (a.x * b.y - a.y * b.x)};
}

// Factors whose product is four orientations.
struct Factors {
  Quaternions4 base;              // the first control, rotated by the offset if there is one
  std::array<Vectors4, 3> steps;  // each times its fraction
  Vectors4 coordinates;

  bool are_short() const {
    bool all = (coordinates.quarter_squared() < kSeriesSquare).all();
    for (const Vectors4& step : steps) all = all && (step.quarter_squared() < kSeriesSquare).all();
    return all;
  }
};

Quaternions4 short_exp(const Vectors4& vector) {
  const Lanes h = vector.quarter_squared();
  const Lanes scale = 0.5 * short_sinc(h);
  return {short_cosine(h), scale * vector.x, scale * vector.y, scale * vector.z};
}

Quaternions4 offsets_at(const Path& offset, const double* phases) {
  std::array<Quaternion, kLanes> offsets;
  Places places;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    offsets[lane] = offset_at(offset, phases[lane]);
    places[lane] = offsets[lane].data();
  }
  return quaternions_at(places);
}

Factors factors_of(const Curve& curve, const Path& offset, const double* phases,
                   const RowsRef& values, Index first) {
  Factors result;
  std::array<double, kLanes> fractions;
  Places controls, coordinates, steps;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const double place = place_on(curve, phases[lane]).share;
    const auto i = std::clamp<Index>(static_cast<Index>(place), 0, curve.controls.rows() - 4);
    fractions[lane] = place - static_cast<double>(i);
    controls[lane] = curve.controls.row(i).data();
    steps[lane] = curve.steps.row(i).data();
    coordinates[lane] = values.row(first + static_cast<Index>(lane)).tail<3>().data();
  }
  result.base = quaternions_at(controls);
  if (!offset.empty()) result.base = compose(offsets_at(offset, phases), result.base);
  result.coordinates = vectors_at(coordinates);
  const Lanes s{fractions[0], fractions[1], fractions[2], fractions[3]};
  const Lanes r = 1.0 - s;
  const std::array<Lanes, 3> shares{1.0 - r * r * r / 6.0,
                                    (1.0 + s * (3.0 + s * (3.0 - 2.0 * s))) / 6.0, s * s * s / 6.0};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vectors4 step = vectors_at(steps);
    result.steps[k] = {shares[k] * step.x, shares[k] * step.y, shares[k] * step.z};
    for (const double*& next : steps) next += 3;
  }
  return result;
}

Quaternions4 product(const Factors& factors) {
  Quaternions4 q = factors.base;
  for (const Vectors4& step : factors.steps) q = compose(q, short_exp(step));
  q = compose(q, short_exp(factors.coordinates));
  const Lanes excess = (q.w * q.w + q.y * q.y) + (q.x * q.x + q.z * q.z) - 1.0;
  const Lanes scale = 1.0 - 0.5 * excess;
  return {q.w * scale, q.x * scale, q.y * scale, q.z * scale};
}

// Orientations at consecutive phases, each with the sign nearest to the one before.
class OrientationWriter {
 public:
  OrientationWriter(const Curve& curve, const Path& offset) : curve_(curve), offset_(offset) {}

  // At the next phases, one per row of values, into rows from `to` on.
  void write(const double* phases, const RowsRef& values, double* to) {
    const Index count = values.rows();
    // The next product depends on the previous one as computed, not on its sign.
    const auto add = [&](Index n, const Quaternion& q) {
      const double along = q.dot(previous_);
      negative_ = negative_ ? along > 0.0 : along < 0.0;
      previous_ = q;
      Eigen::Map<Quaternion>(to + 4 * n) = negative_ ? Quaternion(-q) : q;
    };
    for (Index n = 0; n < count;) {
      check_interrupt();
      if (curve_.representation == Representation::kRotationVector && n + kLanes <= count) {
        const Factors factors = factors_of(curve_, offset_, phases + n, values, n);
        if (factors.are_short()) {
          const Quaternions4 found = product(factors);
          for (Index lane = 0; lane < kLanes; ++lane) add(n++, found.get(lane));
          continue;
        }
      }
      add(n, orientation_at(curve_, offset_, phases[n], values.row(n).tail<3>()));
      ++n;
    }
  }

 private:
  const Curve& curve_;
  const Path& offset_;
  Quaternion previous_ = Quaternion::Zero();
  bool negative_ = false;  // the previous one was written with the opposite sign
};

}  // namespace

so3::Quaternions orientations_at(const Curve& curve, const Path& offset, const VectorRef& phases,
                                 const RowsRef& values) {
  check_argument(values.rows() == phases.size() && values.cols() >= 3,
                 "values: expected a row for each phase, with three coordinates");
  check_argument(is_offset(offset), "offset: expected a path of rotation vectors");
  so3::Quaternions result(phases.size(), 4);
  OrientationWriter(curve, offset).write(phases.data(), values, result.data());
  return result;
}

Poses poses_along(const Forces& forces, const Course& course, const Curve& curve,
                  const Path& offset, const State& state, const VectorRef& phases) {
  check_argument(state.value.size() == 6 && is_offset(offset), "state, offset: expected poses");
  constexpr Index kRun = 16 * kLanes;  // values that stay in the cache
  Poses result{Rows3(phases.size(), 3), so3::Quaternions(phases.size(), 4)};
  OrientationWriter writer(curve, offset);
  Rows values(kRun, state.value.size());
  roll(forces, course, state, phases, [&](Index n, const State& at) {
    const Index row = n % kRun;
    result.positions.row(n) = at.value.head<3>();
    values.row(row) = at.value;
    if (row + 1 == kRun || n + 1 == phases.size())
      writer.write(phases.data() + n - row, values.topRows(row + 1),
                   result.orientations.row(n - row).data());
  });
  return result;
}

Peaks peak_speeds(const Curve& curve, const Path& offset, const VectorRef& phases,
                  const Rollout& motion) {
  check_argument(phases.size() > 1 && motion.slopes.rows() == phases.size(),
                 "phases: expected those of the motion, at least two");
  Peaks peaks;
  for (Index n = 0; n < motion.slopes.rows(); ++n) {
    const double* v = motion.slopes.row(n).data();
    peaks.linear = std::max(peaks.linear, std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
  }
  const so3::Quaternions q = orientations_at(curve, offset, phases, motion.values);
  const Index last = q.rows() - 1;
  const auto count = static_cast<double>(last);
  Vector3 before = Vector3::Zero();
  for (Index n = 0; n <= last; ++n) {
    // Central differences, and at both ends one-sided ones.
    Vector3 between = before;
    if (n < last) {
      const Quaternion step = so3::compose(q.row(n + 1), so3::inverse(q.row(n)));
      between = so3::log(step) * count;
    }
    const Vector3 spin = n == 0 || n == last ? between : Vector3(0.5 * (between + before));
    const double squared = spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2];
    peaks.angular = std::max(peaks.angular, std::sqrt(squared));
    before = between;
  }
  return peaks;
}

}  // namespace leadthrough::dmp
