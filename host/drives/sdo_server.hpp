#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "host/drives/dictionary.hpp"

namespace glenoid::drives {

/// The objects behind an SDO server.
class ObjectServer {
 public:
  /// Bytes of an object; `size` is how many. Text may exceed four bytes.
  virtual Abort read(std::uint16_t index, std::uint8_t sub, std::span<std::uint8_t> into,
                     std::size_t& size) noexcept = 0;
  /// Whether a write would find the object and be allowed, whatever the value.
  virtual Abort writable(std::uint16_t index, std::uint8_t sub) noexcept = 0;
  /// @param size_known  false: the client did not say how many of the four bytes count, the object's type decides
  virtual Abort write(std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> bytes,
                      bool size_known) noexcept = 0;

 protected:
  ~ObjectServer() = default;
};

/// Expedited and segmented transfers of CiA 301, one at a time; block transfers are refused with 05040001h.
class SdoServer {
 public:
  using Message = std::array<std::uint8_t, 8>;

  /// Answer to a request. False: none is due (the client aborted).
  bool respond(const Message& request, ObjectServer& objects, Message& answer) noexcept;

  /// Forgets a transfer that has begun.
  void reset() noexcept { transfer_ = Transfer::None; }

 private:
  enum class Transfer : std::uint8_t { None, Download, Upload };

  Abort begin_download(const Message& request, ObjectServer& objects, Message& answer) noexcept;
  Abort continue_download(const Message& request, ObjectServer& objects, Message& answer) noexcept;
  Abort begin_upload(ObjectServer& objects, Message& answer) noexcept;
  Abort continue_upload(const Message& request, Message& answer) noexcept;

  Transfer transfer_ = Transfer::None;
  std::uint16_t index_ = 0;
  std::uint8_t sub_ = 0;
  bool toggle_ = false;
  std::array<std::uint8_t, 64> bytes_{};
  std::size_t size_ = 0;       ///< bytes held
  std::size_t place_ = 0;      ///< of an upload: bytes sent
  std::size_t announced_ = 0;  ///< of a download: bytes the client promised, 0 unknown
};

}  // namespace glenoid::drives
