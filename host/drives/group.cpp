#include "host/drives/group.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <utility>

#include "host/drives/servo.hpp"

namespace glenoid::drives {
namespace {

constexpr std::size_t kBatch = 64;
constexpr std::uint32_t kSync = 0x80;

bool is_sync(const can::Received& received) noexcept {
  const can::Frame& frame = received.frame;
  return !received.own && frame.id == kSync && !frame.extended && !frame.error && !frame.remote;
}

std::uint64_t answers_due(std::span<const Drive> drives) noexcept {
  std::uint64_t sum = 0;
  for (const Drive& drive : drives) sum += drive.counters().answers_due;
  return sum;
}

}  // namespace

DriveGroup::DriveGroup(can::Port& port, std::vector<Drive> drives, std::vector<ScheduledFault> schedule)
    : port_(&port), drives_(std::move(drives)), schedule_(std::move(schedule)) {
  if (drives_.empty() || drives_.size() > kMostDrives) {
    throw std::invalid_argument("drives = " + std::to_string(drives_.size()) + ": must be 1 to 16");
  }
  for (std::size_t a = 0; a < drives_.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      if (drives_[a].node() != drives_[b].node()) continue;
      throw std::invalid_argument("node " + std::to_string(drives_[a].node()) + ": used twice");
    }
  }
  std::stable_sort(schedule_.begin(), schedule_.end(),
                   [](const ScheduledFault& a, const ScheduledFault& b) { return a.at_ns < b.at_ns; });
}

void DriveGroup::carry(std::unique_ptr<Load> load) {
  if (load && load->joints() != drives_.size()) {
    throw std::invalid_argument("load of " + std::to_string(load->joints()) + " joints on " +
                                std::to_string(drives_.size()) + " drives");
  }
  load_ = std::move(load);
}

/// Lets time pass for the coupled joints, a servo step at a time.
void DriveGroup::move_load() noexcept {
  if (!load_) return;
  std::array<JointState, kMostDrives> states;
  std::array<JointLoad, kMostDrives> loads;
  while (now_ns_ - load_ns_ >= kServoStep_ns) {
    load_ns_ += kServoStep_ns;
    for (std::size_t k = 0; k < drives_.size(); ++k) {
      drives_[k].advance(load_ns_, outbox_);
      states[k] = drives_[k].joint_state();
    }
    load_->act(std::span(states).first(drives_.size()), std::span(loads).first(drives_.size()));
    for (std::size_t k = 0; k < drives_.size(); ++k) drives_[k].set_load(loads[k]);
  }
}

void DriveGroup::step(std::int64_t now_ns) noexcept {
  if (begin_ns_ < 0) begin_ns_ = now_ns_ = load_ns_ = now_ns;
  ++counters_.steps;
  std::array<can::Received, kBatch> batch;
  for (std::size_t count = kBatch; count == kBatch;) {
    count = port_->receive(batch);
    for (std::size_t k = 0; k < count; ++k) {
      if (batch[k].own) continue;
      now_ns_ = std::clamp(batch[k].time_ns, now_ns_, std::max(now_ns_, now_ns));
      const auto rest = std::span(batch).subspan(k + 1, count - k - 1);
      deliver(batch[k], std::any_of(rest.begin(), rest.end(), is_sync));
    }
  }
  now_ns_ = std::max(now_ns_, now_ns);
  run_schedule();
  move_load();
  for (Drive& drive : drives_) drive.advance(now_ns_, outbox_);
  flush();
}

void DriveGroup::deliver(const can::Received& received, bool later_sync_waits) noexcept {
  run_schedule();
  move_load();
  const bool sync = is_sync(received);
  const std::uint64_t due = sync ? answers_due(drives_) : 0;
  for (Drive& drive : drives_) drive.receive(received.frame, now_ns_, outbox_);
  if (!sync) {
    if (outbox_.frames().size() > Outbox::kCapacity / 2) flush();
    return;
  }
  ++counters_.syncs;
  const std::uint64_t refused = counters_.refused_frames;
  flush();
  if (answers_due(drives_) == due) return;
  if (counters_.refused_frames != refused) ++counters_.unanswered_syncs;
  if (later_sync_waits) ++counters_.late_syncs;
}

void DriveGroup::run_schedule() noexcept {
  for (; next_fault_ < schedule_.size() && schedule_[next_fault_].at_ns <= now_ns_ - begin_ns_; ++next_fault_) {
    const ScheduledFault& planned = schedule_[next_fault_];
    for (Drive& drive : drives_) {
      if (planned.node == 0 || planned.node == drive.node()) drive.inject(planned.fault, now_ns_, outbox_);
    }
  }
}

void DriveGroup::flush() noexcept {
  const auto frames = outbox_.frames();
  if (!frames.empty()) counters_.refused_frames += frames.size() - port_->send(frames);
  counters_.refused_frames += outbox_.take_dropped();
  outbox_.clear();
}

}  // namespace glenoid::drives
