#include <gtest/gtest.h>

#include <cmath>

#include "arm/robots.hpp"
#include "leadthrough/arm/urdf.hpp"

namespace leadthrough::urdf_tests {

using test::joint;
using test::link;

namespace {

// "where: why" of a refused document, "" of one that is accepted.
std::string refusal(const std::string& document) {
  const auto answer = urdf::parse(document);
  const auto* error = std::get_if<urdf::Error>(&answer);
  return error == nullptr ? "" : error->where + ": " + error->why;
}

std::string robot(const std::string& inside) { return "<robot name='r'>" + inside + "</robot>"; }

std::string two_links(const std::string& inside, const std::string& type = "revolute") {
  return robot(link("a") + link("b") + joint("j", type, "a", "b", inside));
}

const std::string kLimit = "<limit lower='-1' upper='1' velocity='2' effort='3'/>";

// Links named so that a map destroys the leaf first.
std::string long_chain(int links) {
  std::string text;
  const auto name = [](int i) { return "l" + std::to_string(1'000'000 - i); };
  for (int i = 0; i < links; ++i) text += link(name(i));
  for (int i = 1; i < links; ++i)
    text += joint("j" + std::to_string(i), "fixed", name(i - 1), name(i), "");
  return robot(text);
}

}  // namespace

TEST(Urdf, AWholeRobotIsRead) {
  const auto arm = std::get<urdf::Robot>(urdf::parse(test::crooked_arm()));
  EXPECT_EQ(arm.name, "crooked");
  EXPECT_EQ(arm.links.size(), 10U);
  EXPECT_EQ(arm.joints.size(), 9U);
  EXPECT_EQ(arm.links.front().name, "l0");
  EXPECT_EQ(arm.joints[0].type, urdf::JointType::kPrismatic);
  EXPECT_EQ(arm.joints[0].upper, 0.35);
  EXPECT_EQ(arm.joints[1].effort, 50.0);
  EXPECT_EQ(arm.links[3].inertia.mass, 1.5);
  EXPECT_TRUE(arm.links[3].inertia.moments.isApprox(arm.links[3].inertia.moments.transpose()));
}

TEST(Urdf, AxesAreNormalisedAndLeftOutBoundsAreZero) {
  const auto arm = std::get<urdf::Robot>(
      urdf::parse(two_links("<axis xyz='0 3 4'/><limit upper='1' velocity='2' effort='3'/>")));
  EXPECT_LE((arm.joints[0].axis - Eigen::Vector3d(0, 0.6, 0.8)).norm(), 1e-15);
  EXPECT_EQ(arm.joints[0].lower, 0.0);
  const auto still =
      std::get<urdf::Robot>(urdf::parse(two_links("<limit velocity='2' effort='3'/>")));
  EXPECT_EQ(still.joints[0].lower, 0.0);
  EXPECT_EQ(still.joints[0].upper, 0.0);
}

TEST(Urdf, ContradictoryJointsAreRefusedWithTheReason) {
  EXPECT_EQ(refusal(two_links("<limit lower='-1' upper='1' effort='3'/>")),
            "joint 'j': its <limit> has no velocity");
  EXPECT_EQ(refusal(two_links("<limit lower='-1' upper='1' velocity='3'/>")),
            "joint 'j': its <limit> has no effort");
  EXPECT_EQ(refusal(two_links("")), "joint 'j': a revolute joint needs a <limit>");
  EXPECT_EQ(refusal(two_links("<limit lower='1' upper='-1' velocity='2' effort='3'/>")),
            "joint 'j': its lower limit 1.000000 is above its upper limit -1.000000");
  EXPECT_EQ(refusal(two_links("<limit lower='-1' upper='1' velocity='-2' effort='3'/>")),
            "joint 'j': its velocity limit is negative");
  EXPECT_EQ(refusal(two_links("<limit lower='-1' upper='1' velocity='2' effort='-3'/>")),
            "joint 'j': its effort limit is negative");
  EXPECT_EQ(refusal(two_links("<dynamics damping='-1'/>" + kLimit)),
            "joint 'j': its damping is negative");
  EXPECT_EQ(refusal(two_links("<dynamics friction='-1'/>" + kLimit)),
            "joint 'j': its friction is negative");
  EXPECT_EQ(refusal(two_links("<axis xyz='0 0 0'/>" + kLimit)),
            "joint 'j': its axis is zero or not finite");
  EXPECT_EQ(refusal(two_links("<mimic joint='ghost'/>" + kLimit)),
            "joint 'j': mimics 'ghost', which does not exist");
  EXPECT_EQ(refusal(two_links(kLimit, "hinge")), "joint 'j': its type 'hinge' is unknown");
}

TEST(Urdf, MimicsEndAtTheJointThatLeads) {
  const auto text = [](const std::string& b, const std::string& c) {
    const auto hinge = [](const std::string& name, const std::string& child,
                          const std::string& mimic) {
      return joint(name, "continuous", "base", child, "<axis xyz='0 0 1'/>" + mimic);
    };
    return robot(link("base") + link("la") + link("lb") + link("lc") + hinge("a", "la", "") +
                 hinge("b", "lb", b) + hinge("c", "lc", c));
  };
  const std::string of_c = "<mimic joint='c' multiplier='2' offset='0.1'/>";
  const auto arm = std::get<urdf::Robot>(
      urdf::parse(text(of_c, "<mimic joint='a' multiplier='3' offset='0.2'/>")));
  const auto& mimic = *arm.joints[1].mimic;
  EXPECT_EQ(mimic.joint, "a");
  EXPECT_DOUBLE_EQ(mimic.multiplier, 6.0);
  EXPECT_DOUBLE_EQ(mimic.offset, 0.5);
  EXPECT_EQ(refusal(text("<mimic joint='b'/>", "")),
            "joint 'b': mimics itself, directly or by way of others");
  EXPECT_EQ(refusal(text(of_c, "<mimic joint='b'/>")),
            "joint 'b': mimics itself, directly or by way of others");
  EXPECT_EQ(refusal(text("<mimic joint='c' multiplier='1e200'/>",
                         "<mimic joint='a' multiplier='1e200'/>")),
            "joint 'b': its multiplier or offset is too large");
  const auto still = std::get<urdf::Robot>(
      urdf::parse(text("<mimic joint='a' multiplier='0' offset='0.5'/>", "")));
  EXPECT_EQ(still.joints[1].type, urdf::JointType::kFixed);
  EXPECT_NEAR(still.joints[1].T_parent_child.rotation(1, 0), std::sin(0.5), 1e-15);
}

TEST(Urdf, OnlyJointsThatMoveByThemselvesAreHeld) {
  const auto arm = std::get<urdf::Robot>(urdf::parse(robot(
      link("a") + link("b") + link("c") + link("d") + joint("lead", "revolute", "a", "b", kLimit) +
      joint("follow", "revolute", "b", "c", kLimit + "<mimic joint='lead' multiplier='2'/>") +
      joint("bolt", "fixed", "c", "d", ""))));
  const auto why = [&](const std::string& name, double value) {
    const auto answer = urdf::hold(arm, {{name, value}});
    const auto* error = std::get_if<urdf::Error>(&answer);
    return error == nullptr ? "" : error->where + ": " + error->why;
  };
  EXPECT_EQ(why("lead", 0.5), "");
  EXPECT_EQ(why("ghost", 0.5), "joint 'ghost': does not exist");
  EXPECT_EQ(why("bolt", 0.5), "joint 'bolt': is fixed");
  EXPECT_EQ(why("follow", 0.5), "joint 'follow': mimics 'lead'; lock that one");
  EXPECT_EQ(why("lead", 1.5), "joint 'lead': 1.500000 is outside its limits -1.000000 to 1.000000");
  EXPECT_EQ(why("lead", 0.6),
            "joint 'follow': 1.200000 is outside its limits -1.000000 to 1.000000");
}

TEST(Urdf, NumbersThatAreNotFiniteAreRefused) {
  EXPECT_EQ(refusal(two_links("<origin xyz='0 nan 0'/>" + kLimit)),
            "joint 'j': origin xyz: expected 3 finite numbers up to 1e9, got '0 nan 0'");
  EXPECT_EQ(refusal(two_links("<origin xyz='0 0'/>" + kLimit)),
            "joint 'j': origin xyz: expected 3 finite numbers up to 1e9, got '0 0'");
  EXPECT_EQ(refusal(two_links("<limit lower='-inf' upper='1' velocity='2' effort='3'/>")),
            "joint 'j': limit lower: expected 1 finite number, got '-inf'");
  EXPECT_EQ(refusal(two_links("<limit lower='-1' upper='1e999' velocity='2' effort='3'/>")),
            "joint 'j': limit upper: expected 1 finite number, got '1e999'");
}

TEST(Urdf, EveryRobotIsOneTree) {
  EXPECT_EQ(refusal(robot("")), "robot: has no link");
  EXPECT_EQ(refusal(robot(link("a") + link("a"))), "link 'a': the name appears twice");
  EXPECT_EQ(refusal(robot(link("a") + link("b"))),
            "robot: has several root links, among them 'a' and 'b'");
  EXPECT_EQ(refusal(robot(link("a") + joint("j", "fixed", "a", "b", ""))),
            "joint 'j': child link 'b' does not exist");
  const std::string three = link("a") + link("b") + link("c");
  EXPECT_EQ(
      refusal(robot(three + joint("j", "fixed", "a", "c", "") + joint("k", "fixed", "b", "c", ""))),
      "link 'c': is the child of two joints");
  EXPECT_EQ(refusal(robot(link("a") + link("b") + joint("j", "fixed", "a", "b", "") +
                          joint("k", "fixed", "b", "a", ""))),
            "robot: has no root link: its joints form a loop");
  EXPECT_EQ(
      refusal(robot(three + joint("j", "fixed", "b", "c", "") + joint("k", "fixed", "c", "b", ""))),
      "link 'b': is part of a loop of joints");
}

TEST(Urdf, WhatIsNotXmlIsRefusedWithItsLine) {
  EXPECT_EQ(refusal(""), "line 1: no element");
  EXPECT_EQ(refusal("hello"), "line 1: text outside of any element");
  EXPECT_EQ(refusal("<robot>\n<link>\n</robot>"), "line 3: </robot> closes nothing that is open");
  EXPECT_EQ(refusal("<robot>\n"), "line 2: <robot> is never closed");
  EXPECT_EQ(refusal("<robot name='r"), "line 1: attribute 'name' lacks its quotes");
  EXPECT_EQ(refusal("<!-- never"), "line 1: '<!--' is never closed");
  EXPECT_EQ(refusal("<!DOCTYPE robot [<!ENTITY a 'b'>]><robot/>"),
            "line 1: unsupported markup in '<!'");
  EXPECT_EQ(refusal("<car/>"), "document: expected <robot>, got <car>");
  EXPECT_EQ(refusal(std::string("<robot/>\0", 9)), "document: contains a zero byte");
  EXPECT_EQ(refusal(std::string(std::size_t{17} << 20, ' ')), "document: larger than 16 MiB");
}

TEST(Urdf, DepthAndLengthAreBounded) {
  std::string deep;
  for (int i = 0; i < 1'000'000; ++i) deep += "<a>";
  EXPECT_EQ(refusal(deep), "line 1: elements are nested deeper than 64");
  EXPECT_EQ(refusal(long_chain(static_cast<int>(urdf::kMaxLinks))), "");
  EXPECT_EQ(refusal(long_chain(100'000)), "line 1: more than 200000 elements");
  EXPECT_EQ(refusal(long_chain(20'000)), "robot: has more than 5000 links");
}

namespace {

std::string shaped(const std::string& geometry) {
  return robot("<link name='a'><collision><origin xyz='1 2 3' rpy='0 0 0.5'/><geometry>" +
               geometry + "</geometry></collision></link>");
}

urdf::Geometry collision_of(const std::string& geometry) {
  return std::get<urdf::Robot>(urdf::parse(shaped(geometry))).links[0].collisions.at(0);
}

}  // namespace

TEST(Urdf, CollisionGeometryIsRead) {
  const urdf::Geometry box = collision_of("<box size='0.1 0.2 0.3'/>");
  EXPECT_EQ(box.type, urdf::GeometryType::kBox);
  EXPECT_EQ(box.size, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(box.T_link_shape.position, Eigen::Vector3d(1, 2, 3));
  EXPECT_NEAR(box.T_link_shape.rotation(1, 0), std::sin(0.5), 1e-15);
  EXPECT_EQ(collision_of("<sphere radius='0.4'/>").radius, 0.4);
  EXPECT_EQ(collision_of("<cylinder radius='0.4' length='2'/>").length, 2.0);
  const urdf::Geometry capsule = collision_of("<capsule radius='0.4' length='2'/>");
  EXPECT_EQ(capsule.type, urdf::GeometryType::kCapsule);
  EXPECT_EQ(capsule.length, 2.0);
  EXPECT_EQ(collision_of("<capsule radius='0.4' length='2'></capsule>").radius, 0.4);
  const urdf::Geometry mesh = collision_of("<mesh filename='a&amp;b.stl' scale='1 2 -3'/>");
  EXPECT_EQ(mesh.file, "a&b.stl");
  EXPECT_EQ(mesh.size, Eigen::Vector3d(1, 2, -3));
  EXPECT_EQ(collision_of("<mesh filename='c.stl'/>").size, Eigen::Vector3d::Ones());
}

TEST(Urdf, VisualGeometryIsReadWithItsColour) {
  const auto robot_of = [](const std::string& material) {
    const std::string visual =
        "<visual><geometry><box size='1 1 0'/></geometry><material " + material + "</visual>";
    return std::get<urdf::Robot>(urdf::parse(
        robot("<material name='sky'><color rgba='.1 .2 .9 1'/></material><link name='a'>" + visual +
              "</link>")));
  };
  const urdf::Geometry shared = robot_of("name='sky'/>").links[0].visuals.at(0);
  EXPECT_EQ(shared.size, Eigen::Vector3d(1.0, 1.0, 0.0));
  EXPECT_EQ(shared.colour, Eigen::Vector3d(0.1, 0.2, 0.9));
  const std::string own = "name='sky'><color rgba='1 0 0 1'/></material>";
  EXPECT_EQ(robot_of(own).links[0].visuals.at(0).colour, Eigen::Vector3d::UnitX());
  EXPECT_FALSE(robot_of("name='unknown'/>").links[0].visuals.at(0).colour);
  EXPECT_FALSE(robot_of("name=''><color rgba='red'/></material>").links[0].visuals.at(0).colour);
}

TEST(Urdf, CollisionGeometryWithoutASizeIsRefused) {
  EXPECT_EQ(refusal(shaped("<box size='1 0 1'/>")), "link 'a': a box's sizes must be above zero");
  EXPECT_EQ(refusal(shaped("<box/>")), "link 'a': a box's sizes must be above zero");
  EXPECT_EQ(refusal(shaped("<box size='1 nan 1'/>")),
            "link 'a': box size: expected 3 finite numbers up to 1e9, got '1 nan 1'");
  EXPECT_EQ(refusal(shaped("<sphere radius='-1'/>")),
            "link 'a': a sphere's radius must be above zero");
  EXPECT_EQ(refusal(shaped("<cylinder radius='1'/>")),
            "link 'a': a cylinder's radius and length must be above zero");
  EXPECT_EQ(refusal(shaped("<capsule length='1'/>")),
            "link 'a': a capsule's radius must be above zero and its length not below");
  EXPECT_EQ(refusal(shaped("<mesh/>")), "link 'a': a mesh has no filename");
  EXPECT_EQ(refusal(shaped("<mesh filename='a.stl' scale='0 1 1'/>")),
            "link 'a': a mesh's scale must not be zero");
  EXPECT_EQ(refusal(shaped("<cone/>")), "link 'a': its collision geometry is of no known kind");
  EXPECT_EQ(refusal(robot("<link name='a'><collision/></link>")),
            "link 'a': a collision has no geometry");
}

}  // namespace leadthrough::urdf_tests
