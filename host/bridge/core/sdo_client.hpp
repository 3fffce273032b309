#pragma once

#include <cstdint>
#include <optional>

#include "host/bridge/can/frame.hpp"
#include "host/bridge/core/canopen.hpp"

namespace glenoid::bridge {

/// One expedited SDO transfer at a time with one drive: time-out, retries, abort.
///
///     client.upload(0x1000, 0);
///     if (auto frame = client.poll(now)) send(*frame);   // each cycle
///     client.receive(answer);                            // each answer
///     if (client.done()) ... client.result()
class SdoClient {
 public:
  enum class Outcome : std::uint8_t { None, Done, Aborted, TimedOut };
  struct Result {
    Outcome outcome = Outcome::None;
    std::uint32_t value = 0;  ///< what was read, or the abort code
  };

  SdoClient(std::uint8_t node, std::int64_t timeout_ns, int retries) noexcept
      : node_(node), timeout_ns_(timeout_ns), retries_(retries) {}

  /// Starts a transfer; one under way is forgotten.
  void upload(std::uint16_t index, std::uint8_t subindex) noexcept;
  void download(std::uint16_t index, std::uint8_t subindex, std::uint8_t bytes, std::uint32_t value) noexcept;
  void cancel() noexcept;

  /// The frame to send now, if any: the request, a repetition of it, or the abort after the last time-out.
  [[nodiscard]] std::optional<can::Frame> poll(std::int64_t now_ns) noexcept;
  void receive(const canopen::SdoAnswer& answer) noexcept;

  [[nodiscard]] bool busy() const noexcept { return active_; }
  [[nodiscard]] Result result() const noexcept { return result_; }

 private:
  void begin(const can::Frame& request, std::uint16_t index, std::uint8_t subindex, bool is_upload) noexcept;

  std::uint8_t node_;
  std::int64_t timeout_ns_;
  int retries_;
  can::Frame request_{};
  std::uint16_t index_ = 0;
  std::uint8_t subindex_ = 0;
  bool is_upload_ = false;
  bool active_ = false;
  bool sent_ = false;
  int tries_ = 0;
  std::int64_t deadline_ns_ = 0;
  Result result_{};
};

}  // namespace glenoid::bridge
