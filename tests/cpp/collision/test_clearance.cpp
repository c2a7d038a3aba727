#include <gtest/gtest.h>

#include <random>
#include <variant>

#include "arm/robots.hpp"
#include "leadthrough/collision/clearance.hpp"
#include "leadthrough/collision/edges.hpp"

namespace leadthrough::clearance_tests {

namespace {

// Three links that turn about axes across each other, with a shape of each kind.
std::string spatial_arm() {
  const auto body = [](const std::string& name, const std::string& geometry) {
    return "<link name='" + name + "'><collision><origin xyz='0 0 0.2'/><geometry>" + geometry +
           "</geometry></collision></link>";
  };
  const auto hinge = [](const std::string& axis) {
    return "<origin xyz='0 0 0.4'/><axis xyz='" + axis +
           "'/><limit lower='-3' upper='3' velocity='1' effort='1'/>";
  };
  return "<robot name='spatial'>" + test::link("base") +
         body("first", "<box size='0.1 0.1 0.4'/>") +
         body("second", "<cylinder radius='0.06' length='0.4'/>") +
         body("third", "<sphere radius='0.15'/>") +
         test::joint("j1", "revolute", "base", "first", hinge("0 1 0")) +
         test::joint("j2", "revolute", "first", "second", hinge("1 0 0")) +
         test::joint("j3", "prismatic", "second", "third", hinge("0 0 1")) + "</robot>";
}

struct Spatial {
  urdf::Robot robot = std::get<urdf::Robot>(urdf::parse(spatial_arm()));
  Chain chain = std::get<Chain>(make_chain(robot, "base", "third"));
  CollisionModel model = make_collision_model(robot, chain, "base", "third", {}, {});
  PlacedShapes obstacles{
      {box({0.3, 0.2, 0.4}), {Eigen::Matrix3d::Identity(), {0.5, 0.0, 0.6}}},
      {capsule(0.1, 0.3), {Eigen::Matrix3d::Identity(), {0.0, -0.5, 0.9}}},
      {{}, {Eigen::Matrix3d::Identity(), {-0.6, 0.2, 0.7}}, wall()},
  };

  // A bent sheet of points.
  static std::shared_ptr<const Cloud> wall() {
    Rows3 points(400, 3);
    for (int i = 0; i < 20; ++i)
      for (int k = 0; k < 20; ++k)
        points.row(20 * i + k) << 0.1 * std::cos(0.2 * i), 0.03 * i, 0.03 * k;
    return std::make_shared<const Cloud>(points, 0.02);
  }
};

Rows random_rows(int count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.5, 1.5);
  Rows q(count, 3);
  for (Eigen::Index i = 0; i < q.size(); ++i) q.data()[i] = uniform(random);
  return q;
}

}  // namespace

TEST(Clearance, IsWhatTheDistancesSay) {
  const Spatial arm;
  const Rows q = random_rows(2000);
  constexpr double kMargin = 0.03, kSelfMargin = 0.01;
  const auto outside = nearest_batch(against(arm.model, arm.obstacles), q, 1);
  const auto inside = nearest_batch(itself(arm.model), q, 1);
  const auto clear = clear_batch(whole_arm(arm.model, arm.obstacles, kMargin, kSelfMargin), q);
  int blocked = 0;
  for (std::size_t i = 0; i < clear.size(); ++i) {
    const double room = std::min(outside[i].distance - kMargin, inside[i].distance - kSelfMargin);
    if (std::abs(room) < 2e-6) continue;
    EXPECT_EQ(clear[i], room > 0.0) << i << ": " << room;
    blocked += room < 0.0 ? 1 : 0;
  }
  EXPECT_GT(blocked, 200);
  EXPECT_LT(blocked, 1800);
}

TEST(Clearance, GradientsAreThoseOfDifferences) {
  const Spatial arm;
  const WholeArm whole = whole_arm(arm.model, arm.obstacles, 0.0, 0.0);
  ClearanceTest test(whole);
  const Rows q = random_rows(300);
  constexpr double kStep = 1e-6;
  std::vector<NearPair> here, above, below;
  int compared = 0;
  for (Eigen::Index row = 0; row < q.rows(); ++row) {
    test.near(q.row(row).data(), 0.1, here);
    for (Eigen::Index joint = 0; joint < 3; ++joint) {
      Eigen::Vector3d moved = q.row(row).transpose();
      moved[joint] += kStep;
      test.near(moved.data(), 0.2, above);
      moved[joint] -= 2.0 * kStep;
      test.near(moved.data(), 0.2, below);
      for (const NearPair& pair : here) {
        if (pair.distance < 1e-3) continue;  // nearest points of overlapping bodies may leap
        const auto of_pair = [&](const NearPair& other) { return other.pair == pair.pair; };
        const auto up = std::find_if(above.begin(), above.end(), of_pair);
        const auto down = std::find_if(below.begin(), below.end(), of_pair);
        ASSERT_TRUE(up != above.end() && down != below.end());
        EXPECT_NEAR(pair.gradient[static_cast<std::size_t>(joint)],
                    (up->distance - down->distance) / (2.0 * kStep), 2e-4);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 100);
}

}  // namespace leadthrough::clearance_tests
