// Skills that Python exported (export_skills.py) move here as they do there, to the bit, and
// without allocating memory.

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "base/allocations.hpp"
#include "leadthrough/base/npz.hpp"
#include "leadthrough/guard.hpp"
#include "leadthrough/skill.hpp"

namespace leadthrough::exported_skill_tests {

namespace {

std::string path_of(const std::string& name) {
  return std::string(std::getenv("LEADTHROUGH_EXPORTED")) + "/" + name + ".npz";
}

std::string read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

Npz expected_of(const std::string& name) { return Npz(path_of(name + "_expected")); }

Eigen::VectorXd given(const Npz& file, const std::string& name) {
  return file.has(name) ? file.vector(name) : Eigen::VectorXd();
}

template <typename Work>
void expect_no_allocation(const Work& work) {
  const std::size_t before = test::allocations();
  work();
  EXPECT_EQ(test::allocations() - before, 0U);
}

void expect_steps_of_python(const std::string& name) {
  SCOPED_TRACE(name);
  const Npz expected = expected_of(name);
  Dmp skill(path_of(name));
  skill.begin(given(expected, "start"), given(expected, "goal"), expected.number("duration"));
  const Eigen::VectorXd steps = expected.vector("steps");
  const Eigen::Index size = skill.position().size();
  const Rows position = expected.rows("position", size), velocity = expected.rows("velocity", size);
  Rows orientation, rotating;
  if (skill.is_of_poses()) {
    orientation = expected.rows("orientation", 4);
    rotating = expected.rows("angular_velocity", 3);
  }
  for (Eigen::Index i = 0; i < steps.size(); ++i) {
    expect_no_allocation([&] { skill.step(steps[i]); });
    EXPECT_EQ(skill.position(), position.row(i).transpose()) << i;
    EXPECT_EQ(Eigen::VectorXd(skill.velocity()), velocity.row(i).transpose()) << i;
    if (!skill.is_of_poses()) continue;
    EXPECT_EQ(skill.orientation(), so3::Quaternion(orientation.row(i))) << i;
    EXPECT_EQ(skill.angular_velocity(), so3::Vector3(rotating.row(i))) << i;
  }
}

}  // namespace

TEST(ExportedDmp, StepsAsInPython) {
  for (const char* name : {"points", "joints", "poses"}) expect_steps_of_python(name);
}

TEST(ExportedDmp, NamesItsJoints) {
  EXPECT_EQ(Dmp(path_of("joints")).joint_names()[6], "panda_joint7");
  EXPECT_TRUE(Dmp(path_of("poses")).joint_names().empty());
}

TEST(ExportedDmp, RefusesWrongTargetsAndSteps) {
  Dmp skill(path_of("points"));
  const Eigen::Vector3d three(0.0, 0.0, 0.0);
  EXPECT_THROW(skill.begin(three, {}, 1.0), std::invalid_argument);
  EXPECT_THROW(skill.begin({}, Eigen::Vector2d(NAN, 0.0), 1.0), std::invalid_argument);
  EXPECT_THROW(skill.begin({}, {}, 0.0), std::invalid_argument);
  EXPECT_THROW(skill.step(0.0), std::invalid_argument);
  EXPECT_THROW(skill.step(NAN), std::invalid_argument);
  EXPECT_THROW(skill.orientation(), std::invalid_argument);
}

TEST(ExportedProMp, MovesAsInPython) {
  for (const char* name : {"promp", "rhythmic"}) {
    const Npz expected = expected_of(name);
    ProMp skill(path_of(name));
    const Eigen::Index size = skill.at(0.0).cols();
    const Eigen::VectorXd times = expected.vector("times");
    const char* orders[] = {"position", "velocity", "acceleration"};
    for (int order = 0; order < 3 && expected.has(orders[order]); ++order) {
      const Rows rows = expected.rows(orders[order], size);
      for (Eigen::Index i = 0; i < times.size(); ++i) {
        expect_no_allocation([&] { skill.at(times[i]); });
        EXPECT_EQ(skill.at(times[i]).row(order), rows.row(i)) << name << i;
      }
    }
  }
}

TEST(ExportedProMp, RestsAfterItsEndUnlessItIsRhythmic) {
  ProMp skill(path_of("promp")), cycle(path_of("rhythmic"));
  const Rows end = skill.at(skill.duration());
  EXPECT_EQ(skill.at(2.0 * skill.duration()).row(0), end.row(0));
  EXPECT_TRUE(skill.at(2.0 * skill.duration()).bottomRows(2).isZero(0.0));
  const Rows first = cycle.at(0.3 * cycle.duration());
  EXPECT_TRUE(cycle.at(1.3 * cycle.duration()).isApprox(first, 1e-9));
}

TEST(ExportedPolicy, LeadsAsInPython) {
  for (const char* name : {"open", "closed"}) {
    const Npz expected = expected_of(name);
    const MarchingPolicy policy = load_policy(path_of(name));
    const Eigen::Index size = policy.goal().size();
    const Rows positions = expected.rows("position", size);
    const Rows velocities = expected.rows("velocity", size);
    const double dt = expected.number("dt");
    Eigen::VectorXd at = positions.row(0), velocity = at;
    for (Eigen::Index i = 0; i < positions.rows(); ++i) {
      EXPECT_EQ(at, positions.row(i).transpose()) << name << i;
      expect_no_allocation([&] {
        EXPECT_EQ(policy.velocity(at, velocity), DescentStatus::kOk);
        EXPECT_EQ(policy.step(dt, at), DescentStatus::kOk);
      });
      EXPECT_EQ(velocity, velocities.row(i).transpose()) << name << i;
    }
    at.setConstant(1e3);
    EXPECT_EQ(policy.step(0.01, at), DescentStatus::kStartOutside);
    EXPECT_EQ(at[0], 1e3);
  }
}

TEST(ExportedSkill, IsRefusedByAnotherClassAndWhenDamaged) {
  EXPECT_THROW(Dmp(path_of("promp")), std::invalid_argument);
  EXPECT_THROW(ProMp(path_of("nowhere")), std::invalid_argument);
  const std::string whole = read(path_of("promp")), damaged = path_of("damaged");
  for (std::size_t i = 0; i < whole.size(); i += 37) {
    std::string changed = whole;
    changed[i] = static_cast<char>(changed[i] ^ 0x20);
    for (const std::string& content : {whole.substr(0, i), changed}) {
      std::ofstream(damaged, std::ios::binary) << content;
      try {
        const ProMp skill(damaged);
        EXPECT_EQ(content.size(), whole.size());  // a byte that has no meaning, such as a date
      } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find(damaged), std::string::npos) << error.what();
      }
    }
  }
}

TEST(EmbeddedGuard, CommandsAsInPython) {
  const Npz expected(path_of("guarded"));
  const Arm arm(read(std::getenv("LEADTHROUGH_PANDA")), "panda_link0", "panda_hand");
  const guard::StepLimits limits{expected.vector("lower"),    expected.vector("upper"),
                                 expected.vector("velocity"), expected.vector("acceleration"),
                                 expected.vector("jerk"),     1.0 / expected.number("rate")};
  const auto ball = primitive("sphere", Eigen::VectorXd::Constant(1, 0.1));
  Guard guard(arm, limits, {{Eigen::Matrix3d::Identity(), {0.3, 0.4, 0.4}, *ball}});
  guard.start(expected.vector("q0"));
  EXPECT_TRUE(guard.admit(expected.rows("chunk", 7)));

  const Rows q = expected.rows("q", 7), qd = expected.rows("qd", 7), qdd = expected.rows("qdd", 7);
  ASSERT_EQ(guard.remaining(), q.rows());
  for (Eigen::Index i = 0; i < q.rows(); ++i) {
    expect_no_allocation([&] { guard.next(); });
    EXPECT_EQ(guard.q(), q.row(i).transpose());
    EXPECT_EQ(guard.qd(), qd.row(i).transpose());
    EXPECT_EQ(guard.qdd(), qdd.row(i).transpose());
  }
  guard.next();
  EXPECT_EQ(guard.q(), q.bottomRows(1).transpose());
}

TEST(EmbeddedGuard, RefusesWhatItsRulesForbidAndStops) {
  const Npz expected(path_of("guarded"));
  const Arm arm(read(std::getenv("LEADTHROUGH_PANDA")), "panda_link0", "panda_hand");
  const guard::StepLimits limits{expected.vector("lower"),    expected.vector("upper"),
                                 expected.vector("velocity"), expected.vector("acceleration"),
                                 expected.vector("jerk"),     1.0 / expected.number("rate")};
  const Eigen::VectorXd q0 = expected.vector("q0");
  Guard guard(arm, limits);
  guard.start(q0);
  ASSERT_TRUE(guard.admit(expected.rows("chunk", 7).topRows(10)));
  const Eigen::Index remaining = guard.remaining();
  EXPECT_GT(remaining, 10);  // the stop, too

  Rows wrong = q0.transpose().replicate(5, 1);
  EXPECT_FALSE(guard.admit(wrong + Rows::Constant(5, 7, 0.1)));  // a jump
  wrong(2, 3) = NAN;
  EXPECT_FALSE(guard.admit(wrong));
  EXPECT_THROW(guard.admit(wrong.leftCols(3)), std::invalid_argument);
  EXPECT_EQ(guard.remaining(), remaining);
  while (guard.remaining() > 0) guard.next();
  EXPECT_TRUE(guard.qd().isZero(1e-12));

  // The folded arm touches itself: not even rest is clear.
  Guard folded(arm, limits);
  folded.start(Eigen::VectorXd::Zero(7));
  EXPECT_FALSE(folded.admit(Rows::Zero(1, 7)));
}

}  // namespace leadthrough::exported_skill_tests
