#include "host/drives/sdo_server.hpp"

#include <algorithm>

namespace glenoid::drives {
namespace {

constexpr std::size_t kSegment = 7;    // bytes
constexpr std::size_t kExpedited = 4;  // bytes

constexpr std::uint8_t byte_of(std::size_t value) noexcept { return static_cast<std::uint8_t>(value); }

std::uint32_t number_in(const SdoServer::Message& message) noexcept {
  return static_cast<std::uint32_t>(Dictionary::decode(Type::U32, std::span(message).subspan(4, 4)));
}

void put_number(SdoServer::Message& message, std::uint32_t number) noexcept {
  for (std::size_t k = 0; k < 4; ++k) message[4 + k] = byte_of(number >> (8 * k));
}

}  // namespace

bool SdoServer::respond(const Message& request, ObjectServer& objects, Message& answer) noexcept {
  enum Command : unsigned {
    DownloadSegment = 0,
    DownloadBegin = 1,
    UploadBegin = 2,
    UploadSegment = 3,
    ClientAbort = 4,
    BlockUpload = 5,
    BlockDownload = 6
  };
  const unsigned command = request[0] >> 5U;
  answer = {};
  if (command == ClientAbort) {
    reset();
    return false;
  }
  if (command == DownloadBegin || command == UploadBegin || command == BlockUpload || command == BlockDownload) {
    index_ = static_cast<std::uint16_t>(request[1] | request[2] << 8U);
    sub_ = request[3];
  }
  Abort abort = Abort::UnknownCommand;
  if (command == DownloadBegin) {
    abort = begin_download(request, objects, answer);
  } else if (command == UploadBegin) {
    abort = begin_upload(objects, answer);
  } else if (command == DownloadSegment && transfer_ == Transfer::Download) {
    abort = continue_download(request, objects, answer);
  } else if (command == UploadSegment && transfer_ == Transfer::Upload) {
    abort = continue_upload(request, answer);
  }
  if (abort == Abort::None) return true;
  reset();
  answer = {0x80, byte_of(index_ & 0xFFU), byte_of(index_ >> 8U), sub_};
  put_number(answer, static_cast<std::uint32_t>(abort));
  return true;
}

Abort SdoServer::begin_download(const Message& request, ObjectServer& objects, Message& answer) noexcept {
  reset();
  const bool expedited = (request[0] & 2U) != 0, sized = (request[0] & 1U) != 0;
  if (const Abort abort = objects.writable(index_, sub_); abort != Abort::None) return abort;
  if (expedited) {
    const std::size_t unused = sized ? (request[0] >> 2U) & 3U : 0U;
    const auto data = std::span(request).subspan(4, kExpedited - unused);
    if (const Abort abort = objects.write(index_, sub_, data, sized); abort != Abort::None) return abort;
  } else {
    announced_ = sized ? number_in(request) : 0;
    if (announced_ > bytes_.size()) return Abort::TooLong;
    transfer_ = Transfer::Download;
    toggle_ = false;
    size_ = 0;
  }
  answer = {0x60, request[1], request[2], request[3]};
  return Abort::None;
}

Abort SdoServer::continue_download(const Message& request, ObjectServer& objects, Message& answer) noexcept {
  if (((request[0] & 0x10U) != 0) != toggle_) return Abort::ToggleBit;
  const std::size_t count = kSegment - ((request[0] >> 1U) & 7U);
  if (size_ + count > bytes_.size()) return Abort::TooLong;
  std::copy_n(request.begin() + 1, count, bytes_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += count;
  answer[0] = toggle_ ? 0x30 : 0x20;
  toggle_ = !toggle_;
  if ((request[0] & 1U) == 0) return Abort::None;
  transfer_ = Transfer::None;
  if (announced_ != 0 && announced_ != size_) return Abort::LengthMismatch;
  return objects.write(index_, sub_, std::span(bytes_).first(size_), true);
}

Abort SdoServer::begin_upload(ObjectServer& objects, Message& answer) noexcept {
  reset();
  if (const Abort abort = objects.read(index_, sub_, bytes_, size_); abort != Abort::None) return abort;
  answer = {0, byte_of(index_ & 0xFFU), byte_of(index_ >> 8U), sub_};
  if (size_ >= 1 && size_ <= kExpedited) {
    answer[0] = byte_of(0x43U | (kExpedited - size_) << 2U);
    std::copy_n(bytes_.begin(), size_, answer.begin() + 4);
    return Abort::None;
  }
  answer[0] = 0x41;
  put_number(answer, static_cast<std::uint32_t>(size_));
  transfer_ = Transfer::Upload;
  toggle_ = false;
  place_ = 0;
  return Abort::None;
}

Abort SdoServer::continue_upload(const Message& request, Message& answer) noexcept {
  if (((request[0] & 0x10U) != 0) != toggle_) return Abort::ToggleBit;
  const std::size_t count = std::min(kSegment, size_ - place_);
  const bool last = place_ + count == size_;
  answer[0] = byte_of((toggle_ ? 0x10U : 0U) | (kSegment - count) << 1U | (last ? 1U : 0U));
  std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(place_), count, answer.begin() + 1);
  place_ += count;
  toggle_ = !toggle_;
  if (last) transfer_ = Transfer::None;
  return Abort::None;
}

}  // namespace glenoid::drives
