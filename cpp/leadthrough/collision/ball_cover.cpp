#include "leadthrough/collision/ball_cover.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "leadthrough/collision/convex_distance.hpp"

namespace leadthrough {

namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

// Balls along an axis are at most this many radii apart: they stand out by 8 %.
constexpr double kSpacing = 0.8;
constexpr int kMaxAlongAxis = 32;
// Polytopes are halved until their balls are as small, m, or as many.
constexpr double kFineRadius = 0.03;
constexpr std::size_t kMaxPieces = 14;
// Of the ball around points, which nears the smallest one as 1 / steps (Badoiu and Clarkson 2003).
constexpr int kBallSteps = 60;
// Corners that stand out by less do not count, m2; balls are larger by more, m.
constexpr double kSameLine = 1e-14;
constexpr double kRounding = 1e-6;
// A cut joins all corners of one side to all of the other: of hulls with more corners some are cut.
constexpr int kMaxCorners = 200;
constexpr double kGoldenAngle = 2.399963229728653;  // rad

Ball around(const Points& points) {
  Vector3d centre = Vector3d::Zero();
  for (const Vector3d& point : points) centre += point / static_cast<double>(points.size());
  const auto farthest = [&] {
    return *std::max_element(points.begin(), points.end(), [&](const auto& a, const auto& b) {
      return (a - centre).squaredNorm() < (b - centre).squaredNorm();
    });
  };
  for (int i = 1; i <= kBallSteps; ++i) centre += (farthest() - centre) / (i + 1.0);
  return {centre, (farthest() - centre).norm() + kRounding};
}

// Corners of the convex hull of points in a plane of constant `axis` (Andrew 1979).
Points corners_in_plane(Points points, int axis) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::sort(points.begin(), points.end(), [&](const Vector3d& a, const Vector3d& b) {
    return a[u] < b[u] || (a[u] == b[u] && a[v] < b[v]);
  });
  Points hull;
  const auto append = [&](const Vector3d& point, std::size_t keep) {
    const auto no_left_turn = [&] {
      const Vector3d a = hull.back() - hull[hull.size() - 2], b = point - hull.back();
      return a[u] * b[v] - a[v] * b[u] <= kSameLine;
    };
    while (hull.size() > keep && no_left_turn()) hull.pop_back();
    hull.push_back(point);
  };
  for (const Vector3d& point : points) append(point, 1);
  const std::size_t lower = hull.size();
  for (auto point = points.rbegin(); point != points.rend(); ++point) append(*point, lower);
  hull.pop_back();  // the first one again
  return hull;
}

// The convex hull of points, halved across its longest edge.
std::array<Points, 2> halves(const Points& points) {
  Vector3d low = points.front(), high = points.front();
  for (const Vector3d& point : points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const double middle = 0.5 * (low[axis] + high[axis]);
  std::array<Points, 2> sides;
  for (const Vector3d& point : points) sides[point[axis] > middle].push_back(point);
  Points cut;
  for (const Vector3d& a : sides[0])
    for (const Vector3d& b : sides[1])
      cut.push_back(a + (middle - a[axis]) / (b[axis] - a[axis]) * (b - a));
  for (const Vector3d& point : corners_in_plane(std::move(cut), axis))
    for (Points& side : sides) side.push_back(point);
  return sides;
}

// The largest piece is halved first.
std::vector<Ball> halved(Points corners) {
  std::vector<Points> pieces{std::move(corners)};
  std::vector<Ball> balls{around(pieces.front())};
  while (balls.size() < kMaxPieces) {
    const auto largest = static_cast<std::size_t>(
        std::max_element(balls.begin(), balls.end(),
                         [](const Ball& a, const Ball& b) { return a.radius < b.radius; }) -
        balls.begin());
    if (balls[largest].radius <= kFineRadius) break;
    auto [first, second] = halves(pieces[largest]);
    balls[largest] = around(first);
    balls.push_back(around(second));
    pieces[largest] = std::move(first);
    pieces.push_back(std::move(second));
  }
  return balls;
}

// The farthest corners along directions that are evenly spread over a sphere (Gonzalez 2010).
Points spread_corners(const cores::Hull& core) {
  const auto less = [](const Vector3d& a, const Vector3d& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  };
  std::set<Vector3d, decltype(less)> found(less);
  for (int i = 0; i < kMaxCorners; ++i) {
    const double z = (2.0 * i + 1.0) / kMaxCorners - 1.0, across = std::sqrt(1.0 - z * z);
    found.insert(core.support(
        {across * std::cos(i * kGoldenAngle), across * std::sin(i * kGoldenAngle), z}));
  }
  return {found.begin(), found.end()};
}

// The largest distance of corners from the hull of some of them, m.
double most_outside(const Eigen::Matrix3Xd& corners, const Points& some) {
  Eigen::Matrix3Xd kept(3, static_cast<Eigen::Index>(some.size()));
  for (std::size_t i = 0; i < some.size(); ++i) kept.col(static_cast<Eigen::Index>(i)) = some[i];
  const Convex body = hull(std::move(kept)), point = sphere(0.0);
  double most = kRounding;
  for (const auto& corner : corners.colwise()) {
    const Transform at{Eigen::Matrix3d::Identity(), corner};
    Vector3d normal = corner.normalized();
    if (apart(body, {}, point, at, most, normal)) most = separation(body, {}, point, at).distance;
  }
  return most;
}

// Balls about points on the z axis from -half to half.
std::vector<Ball> along_axis(double half, int count, double radius) {
  std::vector<Ball> balls;
  for (int i = 0; i < count; ++i)
    balls.push_back(
        {(count == 1 ? 0.0 : half * (2.0 * i / (count - 1.0) - 1.0)) * Vector3d::UnitZ(), radius});
  return balls;
}

int pieces_of(double length, double radius) {
  const double pieces = std::ceil(length / (kSpacing * radius));
  return static_cast<int>(std::clamp(pieces, 1.0, static_cast<double>(kMaxAlongAxis)));
}

std::vector<Ball> parts(const cores::Point& /*core*/, double rounding) {
  return {{Vector3d::Zero(), rounding}};
}

// The balls at the ends contain the round ends.
std::vector<Ball> parts(const cores::Segment& core, double rounding) {
  const int pieces = pieces_of(2.0 * core.half, rounding);
  return along_axis(core.half, pieces + 1, std::hypot(rounding, core.half / pieces));
}

// A ball around each slice.
std::vector<Ball> parts(const cores::Cylinder& core, double rounding) {
  const int pieces = pieces_of(2.0 * core.half, core.radius);
  const double half = core.half / pieces;
  return along_axis(core.half - half, pieces, std::hypot(core.radius, half) + rounding);
}

std::vector<Ball> rounded(std::vector<Ball> balls, double rounding) {
  for (Ball& ball : balls) ball.radius += rounding;
  return balls;
}

// Of other cores, of the box around them.
template <typename AnyCore>
std::vector<Ball> parts(const AnyCore& core, double rounding) {
  Vector3d low, high;
  for (int i = 0; i < 3; ++i) {
    high[i] = core.reach(Vector3d::Unit(i));
    low[i] = -core.reach(Vector3d(-Vector3d::Unit(i)));
  }
  Points corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                         i & 4 ? high.z() : low.z());
  return rounded(halved(std::move(corners)), rounding);
}

std::vector<Ball> parts(const cores::Hull& core, double rounding) {
  if (core.corners->points().cols() > kMaxCorners) {
    Points some = spread_corners(core);
    const double outside = most_outside(core.corners->points(), some);
    return rounded(halved(std::move(some)), rounding + outside);
  }
  Points corners;
  for (const auto& corner : core.corners->points().colwise()) corners.emplace_back(corner);
  return rounded(halved(std::move(corners)), rounding);
}

Ball whole(const Convex& body) {
  const auto* hull = std::get_if<cores::Hull>(&body.core);
  if (!hull) return {Vector3d::Zero(), bounding_radius(body)};
  Points corners;
  for (const auto& corner : hull->corners->points().colwise()) corners.emplace_back(corner);
  Ball ball = around(corners);
  ball.radius += body.rounding;
  return ball;
}

}  // namespace

BallCover ball_cover(const Convex& body) {
  return {whole(body),
          std::visit([&](const auto& core) { return parts(core, body.rounding); }, body.core)};
}

}  // namespace leadthrough
