#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "host/drives/object_table.hpp"
#include "host/drives/profile.hpp"

namespace glenoid::drives {

/// SDO abort codes of CiA 301; None means success.
enum class Abort : std::uint32_t {
  None = 0,
  ToggleBit = 0x05030000,
  UnknownCommand = 0x05040001,
  WriteOnly = 0x06010001,
  ReadOnly = 0x06010002,
  SubZeroFirst = 0x06010003,  ///< sub-index 0 must be 0 before the others are written
  NoObject = 0x06020000,
  NotMappable = 0x06040041,
  PdoTooLong = 0x06040042,
  Incompatible = 0x06040043,
  LengthMismatch = 0x06070010,
  TooLong = 0x06070012,
  TooShort = 0x06070013,
  NoSubIndex = 0x06090011,
  ValueRange = 0x06090030,
  NotStored = 0x08000020,  ///< the signature is wrong
  DeviceState = 0x08000022,
  NoData = 0x08000024,
};

inline constexpr std::size_t kTextLength = 40;

/// Text of a VISIBLE_STRING object.
struct Text {
  std::array<char, kTextLength> characters{};
  std::size_t size = 0;

  [[nodiscard]] std::string_view view() const noexcept { return {characters.data(), size}; }
  void assign(std::string_view text) noexcept;
};

/// Values of one drive's objects. Checks address, access and length; what a value means is the drive's business.
class Dictionary {
 public:
  /// @throws std::invalid_argument if the profile names an object that the table lacks or a value its type cannot hold.
  Dictionary(const Profile& profile, std::uint8_t node);

  /// Back to the values of power-up: the communication profile area alone (1000h to 1FFFh), or all.
  void reset(bool communication_only) noexcept;

  /// The parameters as they are become those of power-up (1010h).
  void store() noexcept;
  /// The defaults become those of power-up again (1011h); what holds now is not touched.
  void forget_stored() noexcept { power_up_ = defaults_; }

  /// Row of an address that a peer names, kObjects and a reason if this drive lacks it.
  std::size_t find(std::uint16_t index, std::uint8_t sub, Abort& why) const noexcept;

  [[nodiscard]] bool has(std::size_t row) const noexcept { return present_[row]; }
  [[nodiscard]] std::int64_t get(std::size_t row) const noexcept { return values_[row]; }
  void set(std::size_t row, std::int64_t value) noexcept { values_[row] = value; }

  [[nodiscard]] const Text& text(std::size_t row) const noexcept;
  void set_text(std::size_t row, std::string_view text) noexcept;

  /// Value of a row as little-endian bytes; returns how many. Text is truncated to the room.
  std::size_t encode(std::size_t row, std::span<std::uint8_t> bytes) const noexcept;
  /// Bytes as the row's type; the length must be the type's.
  static std::int64_t decode(Type type, std::span<const std::uint8_t> bytes) noexcept;

 private:
  static constexpr std::size_t kTexts = 4;
  [[nodiscard]] static std::size_t text_place(std::size_t row) noexcept;

  std::array<std::int64_t, kObjects> values_{};
  std::array<std::int64_t, kObjects> defaults_{};
  std::array<std::int64_t, kObjects> power_up_{};
  std::array<bool, kObjects> present_{};
  std::array<Text, kTexts> texts_{};
};

}  // namespace glenoid::drives
