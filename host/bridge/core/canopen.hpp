#pragma once

// CiA 301 on the wire: identifiers, NMT, SDO and the words of its codes.

#include <cstdint>
#include <optional>
#include <string_view>

#include "host/bridge/can/frame.hpp"
#include "host/bridge/core/messages.hpp"

namespace glenoid::bridge::canopen {

inline constexpr std::uint32_t kNmtId = 0x000;
inline constexpr std::uint32_t kSyncId = 0x080;
inline constexpr std::uint32_t kEmergencyId = 0x080;    // plus node id
inline constexpr std::uint32_t kSdoRequestId = 0x600;   // plus node id
inline constexpr std::uint32_t kSdoResponseId = 0x580;  // plus node id
inline constexpr std::uint32_t kHeartbeatId = 0x700;    // plus node id

inline constexpr std::uint32_t kCobInvalid = 0x8000'0000;   // bit 31 of a COB-ID: the PDO does not exist
inline constexpr std::uint32_t kCobNoRemote = 0x4000'0000;  // bit 30: no remote frame allowed on this PDO

enum class NmtCommand : std::uint8_t {
  Start = 0x01,
  Stop = 0x02,
  PreOperational = 0x80,
  ResetNode = 0x81,
  ResetCommunication = 0x82,
};

[[nodiscard]] can::Frame nmt(NmtCommand command, std::uint8_t node) noexcept;
[[nodiscard]] can::Frame sync() noexcept;
[[nodiscard]] can::Frame heartbeat(std::uint8_t node, Nmt state) noexcept;

/// Expedited SDO requests. `bytes` is 1, 2 or 4.
[[nodiscard]] can::Frame sdo_download(std::uint8_t node, std::uint16_t index, std::uint8_t subindex, std::uint8_t bytes,
                                      std::uint32_t value) noexcept;
[[nodiscard]] can::Frame sdo_upload(std::uint8_t node, std::uint16_t index, std::uint8_t subindex) noexcept;
[[nodiscard]] can::Frame sdo_abort(std::uint8_t node, std::uint16_t index, std::uint8_t subindex,
                                   std::uint32_t code) noexcept;

inline constexpr std::uint32_t kAbortTimeout = 0x0504'0000;
inline constexpr std::uint32_t kAbortNoObject = 0x0602'0000;
inline constexpr std::uint32_t kAbortNoSubindex = 0x0609'0011;

/// An answer of an SDO server to an expedited request.
struct SdoAnswer {
  enum class Kind : std::uint8_t { Downloaded, Uploaded, Aborted, Other };
  Kind kind = Kind::Other;
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
  std::uint8_t bytes = 0;   ///< of an upload; 4 where the server does not say
  std::uint32_t value = 0;  ///< of an upload, or the abort code
};

/// Empty unless `frame` has eight bytes and is a plain data frame with an 11-bit identifier.
[[nodiscard]] std::optional<SdoAnswer> sdo_answer(const can::Frame& frame) noexcept;

/// Meaning of an SDO abort code or of an EMCY error code; never empty.
[[nodiscard]] std::string_view abort_words(std::uint32_t code) noexcept;
[[nodiscard]] std::string_view emergency_words(std::uint16_t code) noexcept;
[[nodiscard]] std::string_view words(Nmt state) noexcept;

}  // namespace glenoid::bridge::canopen
