#include "host/bridge/core/sdo_client.hpp"

namespace glenoid::bridge {

void SdoClient::begin(const can::Frame& request, std::uint16_t index, std::uint8_t subindex, bool is_upload) noexcept {
  request_ = request;
  index_ = index;
  subindex_ = subindex;
  is_upload_ = is_upload;
  active_ = true;
  sent_ = false;
  tries_ = 0;
  result_ = {};
}

void SdoClient::upload(std::uint16_t index, std::uint8_t subindex) noexcept {
  begin(canopen::sdo_upload(node_, index, subindex), index, subindex, true);
}

void SdoClient::download(std::uint16_t index, std::uint8_t subindex, std::uint8_t bytes, std::uint32_t value) noexcept {
  begin(canopen::sdo_download(node_, index, subindex, bytes, value), index, subindex, false);
}

void SdoClient::cancel() noexcept {
  active_ = false;
  result_ = {};
}

std::optional<can::Frame> SdoClient::poll(std::int64_t now_ns) noexcept {
  if (!active_) return std::nullopt;
  if (sent_ && now_ns < deadline_ns_) return std::nullopt;
  if (tries_ > retries_) {
    active_ = false;
    result_ = {Outcome::TimedOut, canopen::kAbortTimeout};
    return canopen::sdo_abort(node_, index_, subindex_, canopen::kAbortTimeout);
  }
  sent_ = true;
  ++tries_;
  deadline_ns_ = now_ns + timeout_ns_;
  return request_;
}

void SdoClient::receive(const canopen::SdoAnswer& answer) noexcept {
  if (!active_ || !sent_ || answer.index != index_ || answer.subindex != subindex_) return;
  using Kind = canopen::SdoAnswer::Kind;
  if (answer.kind == Kind::Aborted) {
    result_ = {Outcome::Aborted, answer.value};
  } else if (answer.kind == (is_upload_ ? Kind::Uploaded : Kind::Downloaded)) {
    result_ = {Outcome::Done, answer.value};
  } else {
    return;  // a late answer of the other kind, or a segmented transfer: the time-out decides
  }
  active_ = false;
}

}  // namespace glenoid::bridge
