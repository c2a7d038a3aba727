#include "leadthrough/simulation/run.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "leadthrough/base/argument.hpp"
#include "leadthrough/base/interrupt.hpp"

namespace leadthrough::simulation {

namespace {

using Eigen::Index;

// A period: the joint that runs away, and whether bodies touch in the last step.
std::pair<Index, bool> period(Drives& drives, const Command& command, double progress,
                              const Drives::Law& law, const Physics& physics) {
  bool touching = false;
  Index runaway = drives.begin(command, progress, law);
  for (int step = 0; runaway == kNone && step < drives.values().steps; ++step) {
    drives.act(step);
    touching = physics.step();
    runaway = drives.advance();
  }
  if (runaway == kNone) drives.end();
  return {runaway, touching};
}

constexpr double kRounding = 1e-6;  // of limits, relative

void note_use(Record& record, const Drives& drives, Index k) {
  for (Index i = 0; i < drives.joints(); ++i) {
    const double use = std::abs(drives.demanded()[i]) / drives.values().effort[i];
    record.use[i] = std::max(record.use[i], use);
    if (use > 1.0 + kRounding && record.over[i] == kNone) record.over[i] = k;
  }
}

}  // namespace

Record run(Drives& drives, const Commands& commands, const Drives::Law& law,
           const Physics& physics) {
  const Index count = commands.q.rows(), n = drives.joints();
  for (const RowsRef* each : {&commands.q, &commands.qd, &commands.qdd})
    check_argument(each->rows() == count && each->cols() == n, "commands: rows (n, joints)");
  check_argument(commands.progress.size() == count, "progress: one value a row");
  Record record;
  for (Rows* each : {&record.q, &record.qd, &record.qdd, &record.torques}) each->resize(count, n);
  record.work = record.given = record.use = Eigen::VectorXd::Zero(n);
  record.over.setConstant(n, kNone);
  Command command(3, n);
  Eigen::VectorXd after(n), work(n);
  Index first_touch = count;
  for (Index k = 0; k < count && k - first_touch <= physics.periods_after_touch; ++k) {
    check_interrupt(k);
    const Index next = std::min(k + 1, count - 1);
    command << commands.q.row(next), commands.qd.row(next), commands.qdd.row(k);
    drives.read_q(record.q.row(k).data());
    drives.read_qd(record.qd.row(k).data());
    record.periods = k + 1;
    const auto [runaway, touching] = period(drives, command, commands.progress[k], law, physics);
    record.runaway = runaway;
    if (runaway != kNone) {
      for (Rows* each : {&record.qdd, &record.torques}) each->row(k).setZero();
      break;
    }
    drives.read_qd(after.data());
    record.qdd.row(k) = (after.transpose() - record.qd.row(k)) / drives.values().period;
    record.torques.row(k) = drives.torques();
    if (first_touch == count) note_use(record, drives, k);
    drives.read_q(after.data());
    work = drives.torques().cwiseProduct(after - record.q.row(k).transpose());
    record.work += work;
    record.given += work.cwiseMax(0.0);
    if (!touching) continue;
    first_touch = std::min(first_touch, k);
    physics.touched(k);
  }
  return record;
}

}  // namespace leadthrough::simulation
