// Times steps of exported skills, a million each, for python/benchmarks/control_loop.py:
//
//     time_steps FOLDER PANDA_URDF
//
// A row of a table for each: the median, the time that 99.9 % do not exceed and the worst, us.

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

#include "leadthrough/base/npz.hpp"
#include "leadthrough/guard.hpp"
#include "leadthrough/skill.hpp"

namespace {

constexpr int kSteps = 1'000'000, kPeriod = 1000;
constexpr double kStep = 1e-3;  // s

// begin: before every period of steps, not timed.
void time(const std::string& name, const std::function<void()>& begin,
          const std::function<void(int)>& step) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> times(kSteps);
  for (int i = 0; i < kSteps; ++i) {
    if (i % kPeriod == 0) begin();
    const Clock::time_point start = Clock::now();
    step(i);
    times[static_cast<std::size_t>(i)] =
        std::chrono::duration<double, std::micro>(Clock::now() - start).count();
  }
  std::sort(times.begin(), times.end());
  std::cout << "| " << name << " | " << times[kSteps / 2] << " | " << times[kSteps / 1000 * 999]
            << " | " << times.back() << " |\n";
}

}  // namespace

int main(int, char** words) {
  using namespace leadthrough;
  const std::string folder = std::string(words[1]) + "/";
  Dmp joints(folder + "joints.npz"), poses(folder + "poses.npz");
  ProMp promp(folder + "promp.npz");
  const MarchingPolicy policy = load_policy(folder + "open.npz");
  const Rows places = Npz(folder + "open_expected.npz").rows("position", 3);
  const Npz guarded(folder + "guarded.npz");
  std::ifstream file(words[2]);
  const std::string urdf(std::istreambuf_iterator<char>(file), {});
  Guard guard(Arm(urdf, "panda_link0", "panda_hand"),
              {guarded.vector("lower"), guarded.vector("upper"), guarded.vector("velocity"),
               guarded.vector("acceleration"), guarded.vector("jerk"), 0.01});
  guard.start(guarded.vector("q0"));

  volatile double read = 0.0;
  time(
      "`Dmp::step`, 7 joints", [&] { joints.begin({}, {}, joints.duration()); },
      [&](int) {
        joints.step(kStep);
        read = joints.position()[0];
      });
  time(
      "`Dmp::step`, reading the pose", [&] { poses.begin({}, {}, poses.duration()); },
      [&](int) {
        poses.step(kStep);
        read = poses.position()[0] + poses.orientation()[0];
      });
  time(
      "`ProMp::at`, 6 joints, 20 functions", [] {},
      [&](int i) { read = promp.at(i % kPeriod * kStep)(0, 0); });
  Eigen::VectorXd place(3);
  time(
      "`MarchingPolicy::step`, 3-D", [&] { place = places.row(0); },
      [&](int) { policy.step(kStep, place); });
  const Rows chunk = guarded.rows("chunk", 7);
  time(
      "`Guard::next`, 7 joints",
      [&] {
        guard.start(chunk.row(0));
        guard.admit(chunk);
      },
      [&](int) {
        guard.next();
        read = guard.q()[0];
      });
}
