#include "host/drives/line.hpp"

#include <algorithm>

namespace glenoid::drives {

void Line::cut(bool is_cut) noexcept {
  cut_ = is_cut;
  if (is_cut) count_ = 0;
}

bool Line::loses() noexcept {
  if (loss_per_mille_ == 0) return false;
  // splitmix64 (Steele, Lea and Flood, OOPSLA 2014)
  random_ += 0x9E3779B97F4A7C15;
  std::uint64_t z = random_;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EB;
  return (z ^ (z >> 31U)) % 1000U < loss_per_mille_;
}

bool Line::delivers() noexcept { return !cut_ && !loses(); }

void Line::send(const can::Frame& frame, std::int64_t now_ns, Outbox& out) noexcept {
  if (cut_ || loses()) return;
  if (delay_ns_ == 0 && count_ == 0) {
    out.push(frame);
  } else if (count_ < waiting_.size()) {
    waiting_[count_++] = {frame, now_ns + delay_ns_};
  }
}

void Line::advance(std::int64_t now_ns, Outbox& out) noexcept {
  std::size_t gone = 0;
  while (gone < count_ && waiting_[gone].due_ns <= now_ns) out.push(waiting_[gone++].frame);
  if (gone == 0) return;
  std::copy(waiting_.begin() + static_cast<std::ptrdiff_t>(gone),
            waiting_.begin() + static_cast<std::ptrdiff_t>(count_), waiting_.begin());
  count_ -= gone;
}

}  // namespace glenoid::drives
