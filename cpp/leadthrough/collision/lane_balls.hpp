#pragma once

// The balls of an arm against each other and against boxes around its obstacles, for eight
// configurations at once in single precision.

#include <array>
#include <cstdint>
#include <vector>

#include "leadthrough/collision/clearance.hpp"
#include "leadthrough/collision/lanes.hpp"

namespace leadthrough {

class LaneBalls {
 public:
  // Bit j: pair certainly keeps its margin around configuration j.
  using Passed = std::uint8_t;
  // Values of the moving joints in eight configurations.
  struct alignas(lanes::Values) Joints {
    lanes::Values value[kMaxJoints];
  };

  explicit LaneBalls(const WholeArm& arm);

  // Values of the moving joints at the ends of the edge. False if its joints lie too far out for
  // bounds and single precision.
  bool set_edge(const MovingValues& start, const MovingValues& end);
  // passed[i]: of pair open[i], while the joints change by up to `fraction` of the edge.
  void test(const Joints& values, float fraction, const std::vector<std::size_t>& open,
            std::vector<Passed>& passed);
  // Bound on the motion of any ball along the edge, m.
  float longest_motion() const { return longest_motion_; }

 private:
  struct BallInJoint {
    std::array<float, 3> centre;  // in the frame that the joint carries
    float radius;
    int frame;                                 // that it moves with
    std::array<float, kMaxJoints> reach;       // from each joint's axis, m
    std::array<float, kMaxJoints + 1> travel;  // along the edge, by its joints before each
  };
  // The ball around a whole body is first, then its parts.
  struct BallsOfBody {
    std::size_t whole, end;
    bool placed;  // the parts, at the present configurations
  };
  struct RoundedBox {
    std::array<float, 9> rotation;  // rows: its axes in the base frame
    std::array<float, 3> position, half;
    float rounding;
    bool round;  // a disc across z with the radius half[0]
  };
  // b is a body; a is a body or an obstacle.
  struct Pair {
    std::size_t a, b;
    std::size_t first_joint;  // after those that move both
    float margin;
    bool obstacle;
  };
  struct alignas(lanes::Values) Point {
    lanes::Values axis[3];
  };
  struct alignas(lanes::Values) Frame {
    lanes::Values rotation[9];  // by rows
    Point position;
  };

  void add_body(const BodyShape& shape, int frame);
  void add_obstacle(const BodyShape& shape);
  void add_ball(const Ball& ball, const Transform& T_frame_shape, int frame);

  // The same code for each instruction set.
  void run(const Joints& values, float fraction, const std::vector<std::size_t>& open,
           std::vector<Passed>& passed);
  void run_wide(const Joints& values, float fraction, const std::vector<std::size_t>& open,
                std::vector<Passed>& passed);
  void run_here(const Joints& values, float fraction, const std::vector<std::size_t>& open,
                std::vector<Passed>& passed);
  void place_frame(std::size_t k, const lanes::Values& value);
  void place_ball(std::size_t ball);
  void place_parts(std::size_t body);
  void pass_obstacle(const Pair& pair, float fraction, lanes::Flags& flags);
  void pass_bodies(const Pair& pair, float fraction, lanes::Flags& flags);
  void clear_of_box(const RoundedBox& box, std::size_t ball, float least,
                    lanes::Flags& flags) const;
  void clear_of_ball(std::size_t a, std::size_t b, float least, lanes::Flags& flags) const;
  float own_motion(const Pair& pair, std::size_t ball, float fraction) const;

  const Chain chain_;
  MovingValues extent_;                                    // within which the balls' reaches hold
  std::array<std::array<float, 12>, kMaxJoints> fixed_{};  // rows of the rotation, position
  std::vector<BallInJoint> balls_;
  std::vector<BallsOfBody> bodies_;
  std::vector<RoundedBox> boxes_;
  std::vector<Pair> pairs_;
  float longest_motion_ = 0.0F;

  Frame frames_[kMaxJoints + 1]{};
  std::vector<Point> centres_;
};

}  // namespace leadthrough
