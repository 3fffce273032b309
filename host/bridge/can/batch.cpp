#include "host/bridge/can/batch.hpp"

#include <linux/filter.h>
#include <netinet/udp.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <system_error>

namespace glenoid::can {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
// A stamp older than this was taken before somebody set the wall clock, or nobody has read for too long: now is better.
constexpr std::int64_t kOldestStamp_ns = 10 * kSecond_ns;

std::int64_t nanoseconds(const timespec& time) noexcept { return time.tv_sec * kSecond_ns + time.tv_nsec; }

std::int64_t clock_ns(clockid_t clock) noexcept {
  timespec time{};
  ::clock_gettime(clock, &time);
  return nanoseconds(time);
}

}  // namespace

ReceiveBatch::ReceiveBatch() noexcept {
  for (std::size_t k = 0; k < kSlots; ++k) vectors_[k] = {payloads_[k].data(), kPayload};
}

int ReceiveBatch::receive(int descriptor, std::size_t most) noexcept {
  const std::size_t slots = most < kSlots ? most : kSlots;
  for (std::size_t k = 0; k < slots; ++k) {
    msghdr& header = messages_[k].msg_hdr;
    header = {};
    header.msg_name = &sources_[k];
    header.msg_namelen = sizeof sources_[k];
    header.msg_iov = &vectors_[k];
    header.msg_iovlen = 1;
    header.msg_control = controls_[k].bytes.data();
    header.msg_controllen = controls_[k].bytes.size();
  }
  const int count = ::recvmmsg(descriptor, messages_.data(), static_cast<unsigned>(slots), MSG_DONTWAIT, nullptr);
  if (count < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR ? 0 : -errno;
  const std::int64_t now_ns = clock_ns(CLOCK_MONOTONIC);
  const std::int64_t shift_ns = now_ns - clock_ns(CLOCK_REALTIME);
  for (int k = 0; k < count; ++k) read_control(static_cast<std::size_t>(k), shift_ns, now_ns);
  return count;
}

void ReceiveBatch::read_control(std::size_t k, std::int64_t monotonic_minus_real_ns, std::int64_t now_ns) noexcept {
  times_ns_[k] = now_ns;
  msghdr& header = messages_[k].msg_hdr;
  for (cmsghdr* control = CMSG_FIRSTHDR(&header); control != nullptr; control = CMSG_NXTHDR(&header, control)) {
    if (control->cmsg_level != SOL_SOCKET) continue;
    if (control->cmsg_type == SO_TIMESTAMPNS) {
      timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(control), sizeof stamp);
      const std::int64_t time_ns = nanoseconds(stamp) + monotonic_minus_real_ns;
      if (time_ns <= now_ns && now_ns - time_ns < kOldestStamp_ns) times_ns_[k] = time_ns;
    } else if (control->cmsg_type == SO_RXQ_OVFL) {
      std::uint32_t dropped = 0;
      std::memcpy(&dropped, CMSG_DATA(control), sizeof dropped);
      dropped_ += dropped - dropped_before_;  // modulo 2^32, as the kernel counts
      dropped_before_ = dropped;
    }
  }
}

SendBatch::SendBatch() noexcept {
  for (std::size_t k = 0; k < kSlots; ++k) {
    messages_[k].msg_hdr.msg_iov = &vectors_[k];
    messages_[k].msg_hdr.msg_iovlen = 1;
  }
}

void SendBatch::set(std::size_t k, std::span<const char> bytes, std::uint16_t segment) noexcept {
  vectors_[k] = {const_cast<char*>(bytes.data()), bytes.size()};  // sendmmsg does not write there
  msghdr& header = messages_[k].msg_hdr;
  header.msg_control = segment != 0 ? controls_[k].bytes.data() : nullptr;
  header.msg_controllen = segment != 0 ? controls_[k].bytes.size() : 0;
  if (segment == 0) return;
  cmsghdr* const control = CMSG_FIRSTHDR(&header);
  control->cmsg_level = SOL_UDP;
  control->cmsg_type = UDP_SEGMENT;
  control->cmsg_len = CMSG_LEN(sizeof segment);
  std::memcpy(CMSG_DATA(control), &segment, sizeof segment);
}

int SendBatch::send(int descriptor, std::size_t count) noexcept {
  const int sent = ::sendmmsg(descriptor, messages_.data(), static_cast<unsigned>(count), MSG_DONTWAIT);
  return sent < 0 ? -errno : sent;
}

bool set_option(int descriptor, int level, int option, int value) noexcept {
  return ::setsockopt(descriptor, level, option, &value, sizeof value) == 0;
}

void prepare_reception(int descriptor, int buffer_bytes) noexcept {
  if (!set_option(descriptor, SOL_SOCKET, SO_RCVBUFFORCE, buffer_bytes)) {
    set_option(descriptor, SOL_SOCKET, SO_RCVBUF, buffer_bytes);
  }
  set_option(descriptor, SOL_SOCKET, SO_TIMESTAMPNS, 1);
  set_option(descriptor, SOL_SOCKET, SO_RXQ_OVFL, 1);
}

bool drop_from(int descriptor, std::uint16_t port) noexcept {
  std::array<sock_filter, 4> program = {{
      BPF_STMT(BPF_LD | BPF_H | BPF_ABS, 0),  // the source port begins the UDP header
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, port, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, 0),
      BPF_STMT(BPF_RET | BPF_K, 0xFFFFFFFF),
  }};
  const sock_fprog filter{program.size(), program.data()};
  return ::setsockopt(descriptor, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) == 0;
}

std::string failure(std::string_view what, int error, std::string_view hint) {
  std::string text(what);
  text += ": " + std::generic_category().message(error);
  if (!hint.empty()) text += std::string("; ") + std::string(hint);
  return text;
}

}  // namespace glenoid::can
