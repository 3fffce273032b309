#include "host/bridge/can/error_frame.hpp"

#include <linux/can/error.h>

#include <string_view>

namespace glenoid::can {
namespace {

/// data[1] of CAN_ERR_CRTL.
void read_controller(std::uint8_t bits, ErrorReport& report) noexcept {
  report.receive_overflow = (bits & CAN_ERR_CRTL_RX_OVERFLOW) != 0;
  report.transmit_overflow = (bits & CAN_ERR_CRTL_TX_OVERFLOW) != 0;
  constexpr std::uint8_t kWarning = CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING;
  constexpr std::uint8_t kPassive = CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE;
  if ((bits & (kWarning | kPassive | CAN_ERR_CRTL_ACTIVE)) == 0) return;
  report.has_state = true;
  report.state = (bits & kPassive) != 0   ? ControllerState::Passive
                 : (bits & kWarning) != 0 ? ControllerState::Warning
                                          : ControllerState::Active;
}

void append(std::string& text, bool condition, std::string_view words) {
  if (!condition) return;
  if (!text.empty()) text += "; ";
  text += words;
}

std::string_view words_of(ControllerState state) noexcept {
  switch (state) {
    case ControllerState::Active:
      return "error active";
    case ControllerState::Warning:
      return "error warning";
    case ControllerState::Passive:
      return "error passive";
    case ControllerState::Off:
      return "bus off";
  }
  return "unknown state";
}

}  // namespace

ErrorReport decode_error(const Frame& frame) noexcept {
  ErrorReport report;
  if (!frame.error) return report;
  const std::uint32_t classes = frame.id;
  report.transmit_timeout = (classes & CAN_ERR_TX_TIMEOUT) != 0;
  report.lost_arbitration = (classes & CAN_ERR_LOSTARB) != 0;
  report.no_acknowledge = (classes & CAN_ERR_ACK) != 0;
  report.bus_error = (classes & (CAN_ERR_BUSERROR | CAN_ERR_PROT)) != 0;
  if ((classes & CAN_ERR_CRTL) != 0) read_controller(frame.data[1], report);
  // CAN_ERR_CNT came with Linux 6.0; drivers before it filled the counters without saying so.
  report.has_counters = (classes & CAN_ERR_CNT) != 0 || (frame.data[6] | frame.data[7]) != 0;
  report.tx_errors = frame.data[6];
  report.rx_errors = frame.data[7];
  report.restarted = (classes & CAN_ERR_RESTARTED) != 0;
  if (report.restarted) {
    report.has_state = true;
    report.state = ControllerState::Active;
  }
  if ((classes & CAN_ERR_BUSOFF) != 0) {
    report.has_state = true;
    report.state = ControllerState::Off;
  }
  return report;
}

std::string describe_error(const Frame& frame) {
  if (!frame.error) return "no error frame";
  const ErrorReport report = decode_error(frame);
  std::string text;
  append(text, report.has_state, words_of(report.state));
  append(text, report.restarted, "controller restarted");
  append(text, report.transmit_timeout, "transmission timed out");
  append(text, report.receive_overflow, "receive buffer of the controller overflowed");
  append(text, report.transmit_overflow, "transmit buffer of the controller overflowed");
  append(text, report.lost_arbitration, "arbitration lost");
  append(text, report.no_acknowledge, "nobody acknowledges");
  append(text, report.bus_error, "bus error");
  append(text, (frame.id & CAN_ERR_TRX) != 0, "transceiver fault, wiring");
  append(text, text.empty() && !report.has_counters, "error of unknown class");
  if (report.has_counters) {
    append(text, true, "transmit error counter " + std::to_string(report.tx_errors) + ", receive error counter ");
    text += std::to_string(report.rx_errors);
  }
  return text;
}

Frame make_error(ControllerState state, std::uint8_t tx_errors, std::uint8_t rx_errors) noexcept {
  Frame frame;
  frame.error = true;
  frame.size = CAN_ERR_DLC;
  frame.id = CAN_ERR_CNT | (state == ControllerState::Off ? CAN_ERR_BUSOFF : CAN_ERR_CRTL);
  const bool transmitting = tx_errors >= rx_errors;
  if (state == ControllerState::Active) frame.data[1] = CAN_ERR_CRTL_ACTIVE;
  if (state == ControllerState::Warning)
    frame.data[1] = transmitting ? CAN_ERR_CRTL_TX_WARNING : CAN_ERR_CRTL_RX_WARNING;
  if (state == ControllerState::Passive)
    frame.data[1] = transmitting ? CAN_ERR_CRTL_TX_PASSIVE : CAN_ERR_CRTL_RX_PASSIVE;
  frame.data[6] = tx_errors;
  frame.data[7] = rx_errors;
  return frame;
}

}  // namespace glenoid::can
