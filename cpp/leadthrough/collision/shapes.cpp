#include "leadthrough/collision/shapes.hpp"

#include <Eigen/Geometry>
#include <array>
#include <type_traits>
#include <utility>

#include "leadthrough/base/constants.hpp"

namespace leadthrough {

namespace {

using HullsPointer = std::shared_ptr<const Hulls>;
using CloudPointer = std::shared_ptr<const Cloud>;

// A row of primitives: the number of sizes, and the body of them.
struct PrimitiveKind {
  std::string_view name;
  Eigen::Index sizes;
  Convex (*make)(const Eigen::VectorXd& sizes);
};

const std::array kPrimitives{
    PrimitiveKind{"box", 3, [](const Eigen::VectorXd& sizes) { return box(sizes); }},
    PrimitiveKind{"sphere", 1, [](const Eigen::VectorXd& sizes) { return sphere(sizes[0]); }},
    PrimitiveKind{"capsule", 2,
                  [](const Eigen::VectorXd& sizes) { return capsule(sizes[0], sizes[1]); }},
    PrimitiveKind{"cylinder", 2,
                  [](const Eigen::VectorXd& sizes) { return cylinder(sizes[0], sizes[1]); }},
};

template <typename... Answers>
struct Overloaded : Answers... {
  using Answers::operator()...;
};
template <typename... Answers>
Overloaded(Answers...) -> Overloaded<Answers...>;

// To a point in the frame of the body.
Separation by_iteration(const Convex& body, const Eigen::Vector3d& point, double cutoff) {
  const Transform here;
  return separation(body, here, sphere(0.0), {Eigen::Matrix3d::Identity(), point}, cutoff);
}

SignedDistance from_convex(const Convex& body, const Eigen::Vector3d& point) {
  return std::visit(
      [&](const auto& core) -> SignedDistance {
        if constexpr (std::decay_t<decltype(core)>::kClosedForm) {
          const SignedDistance found = core.signed_distance(point);
          return {found.distance - body.rounding, found.gradient};
        } else {
          const Separation found = by_iteration(body, point, kInfinity);
          return {found.distance, found.normal};
        }
      },
      body.core);
}

// From inside a hull the nearest surface is in its shallowest direction.
SignedDistance from_hulls(const Hulls& hulls, const Eigen::Vector3d& point) {
  SignedDistance least{kInfinity, Eigen::Vector3d::UnitX()};
  for (const auto& [hull, middle, radius] : hulls) {
    if ((point - middle).norm() - radius >= least.distance) continue;
    const Separation found = by_iteration(hull, point - middle, least.distance);
    if (found.distance < least.distance) least = {found.distance, found.normal};
  }
  return least;
}

SignedDistance from_cloud(const Cloud& cloud, const Eigen::Vector3d& point) {
  const SignedDistance found = cores::Point{}.signed_distance(point - cloud.nearest_to(point));
  return {found.distance - cloud.radius(), found.gradient};
}

double reach_of_hulls(const Hulls& hulls, const Eigen::Vector3d& direction) {
  double most = -kInfinity;
  for (const auto& [hull, middle, radius] : hulls) {
    const double own =
        std::visit([&](const auto& core) { return core.reach(direction); }, hull.core);
    most = std::max(most, direction.dot(middle) + own);
  }
  return most;
}

// In a frame of this orientation.
Eigen::Vector3d turned_back(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& v) {
  return v.x() * rotation.row(0) + v.y() * rotation.row(1) + v.z() * rotation.row(2);
}

}  // namespace

std::optional<Convex> primitive(std::string_view kind, const Eigen::VectorXd& sizes) {
  for (const PrimitiveKind& each : kPrimitives)
    if (each.name == kind && each.sizes == sizes.size()) return each.make(sizes);
  return std::nullopt;
}

Shape make_hulls(const std::vector<Rows3>& corners, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& position) {
  Eigen::AlignedBox3d around;
  for (const Rows3& own : corners)
    for (Eigen::Index i = 0; i < own.rows(); ++i) around.extend(own.row(i).transpose());
  const Eigen::Vector3d middle = around.center();
  Hulls hulls;
  for (const Rows3& own : corners) {
    const Eigen::Vector3d centre =
        0.5 * (own.colwise().minCoeff() + own.colwise().maxCoeff()).transpose();
    const Convex convex = hull(own.transpose().colwise() - centre);
    hulls.push_back({convex, centre - middle, bounding_radius(convex)});
  }
  return {rotation, rotation * middle + position, std::make_shared<const Hulls>(std::move(hulls))};
}

Shape make_cloud(std::shared_ptr<const Cloud> cloud, const Eigen::Matrix3d& rotation,
                 const Eigen::Vector3d& position) {
  const Eigen::Vector3d middle = rotation * cloud->middle() + position;
  return {rotation, middle, std::move(cloud)};
}

SignedDistance signed_distance(const Shape& shape, const Eigen::Vector3d& point) {
  const Eigen::Vector3d local = shape.rotation.transpose() * (point - shape.position);
  SignedDistance answer =
      std::visit(Overloaded{[&](const Convex& body) { return from_convex(body, local); },
                            [&](const HullsPointer& hulls) { return from_hulls(*hulls, local); },
                            [&](const CloudPointer& cloud) { return from_cloud(*cloud, local); }},
                 shape.body);
  answer.gradient = (shape.rotation * answer.gradient).eval();
  return answer;
}

double distance_to(const Shape& shape, const Eigen::Vector3d& point) {
  const auto* body = std::get_if<Convex>(&shape.body);
  if (!body) return signed_distance(shape, point).distance;
  const Eigen::Vector3d offset = point - shape.position;
  if (std::holds_alternative<cores::Point>(body->core))  // has no orientation
    return cores::Point{}.distance(offset) - body->rounding;
  return std::visit(
      [&](const auto& core) {
        if constexpr (std::decay_t<decltype(core)>::kClosedForm)
          return core.distance(turned_back(shape.rotation, offset)) - body->rounding;
        else
          return signed_distance(shape, point).distance;
      },
      body->core);
}

double reach_of(const Shape& shape, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d local = shape.rotation.transpose() * direction;
  const auto of_convex = [&](const Convex& body) {
    return std::visit([&](const auto& core) { return core.reach(local); }, body.core) +
           body.rounding;
  };
  return std::visit(
      Overloaded{of_convex,
                 [&](const HullsPointer& hulls) { return reach_of_hulls(*hulls, local); },
                 [&](const CloudPointer& cloud) { return cloud->reach(local); }},
      shape.body);
}

PlacedShapes placed_shapes(const std::vector<Shape>& shapes) {
  PlacedShapes placed;
  for (const Shape& shape : shapes) {
    const Transform pose{shape.rotation, shape.position};
    const auto add_hulls = [&](const HullsPointer& hulls) {
      bool piece = false;
      for (const auto& [convex, middle, radius] : *hulls) {
        const Eigen::Vector3d position = pose.rotation * middle + pose.position;
        placed.push_back({convex, {pose.rotation, position}, nullptr, piece});
        piece = true;
      }
    };
    std::visit(Overloaded{[&](const Convex& body) { placed.push_back({body, pose}); }, add_hulls,
                          [&](const CloudPointer& cloud) { placed.push_back({{}, pose, cloud}); }},
               shape.body);
  }
  return placed;
}

}  // namespace leadthrough
