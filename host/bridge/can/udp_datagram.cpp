#include "host/bridge/can/udp_datagram.hpp"

#include <algorithm>
#include <cstring>
#include <msgpack.hpp>
#include <string_view>
#include <utility>

namespace glenoid::can {
namespace {

enum class Key : std::uint8_t { Id, Extended, Remote, Error, Size, Data, Fd, Ignored };

struct NamedKey {
  std::string_view name;
  Key key;
};
// In the order in which python-can packs them.
constexpr std::array<NamedKey, 11> kKeys = {{
    {"timestamp", Key::Ignored},
    {"arbitration_id", Key::Id},
    {"is_extended_id", Key::Extended},
    {"is_remote_frame", Key::Remote},
    {"is_error_frame", Key::Error},
    {"channel", Key::Ignored},
    {"dlc", Key::Size},
    {"data", Key::Data},
    {"is_fd", Key::Fd},
    {"bitrate_switch", Key::Ignored},
    {"error_state_indicator", Key::Ignored},
}};
constexpr std::uint32_t kRequired = (1u << static_cast<unsigned>(Key::Id)) | (1u << static_cast<unsigned>(Key::Size)) |
                                    (1u << static_cast<unsigned>(Key::Data));

/// Called by the parser with each piece; false stops it. Anything that nests is refused, so that depth is bounded.
class FrameVisitor : public msgpack::null_visitor {
 public:
  void init() noexcept {
    frame_ = {};
    frame_.extended = true;  // what python-can takes where the key is missing
    bytes_ = 0;
    seen_ = 0;
    in_map_ = is_key_ = fd_ = false;
  }

  bool start_map(std::uint32_t) noexcept { return !std::exchange(in_map_, true); }
  bool start_map_key() noexcept { return is_key_ = true; }
  bool end_map_key() noexcept { return !(is_key_ = false); }
  bool start_array(std::uint32_t) noexcept { return false; }
  bool visit_ext(const char*, std::uint32_t) noexcept { return false; }
  bool visit_nil() noexcept { return is_ignored(); }
  bool visit_float32(float) noexcept { return is_ignored(); }
  bool visit_float64(double) noexcept { return is_ignored(); }
  bool visit_negative_integer(std::int64_t) noexcept { return is_ignored(); }

  bool visit_boolean(bool value) noexcept {
    switch (key_) {
      case Key::Extended:
        frame_.extended = value;
        break;
      case Key::Remote:
        frame_.remote = value;
        break;
      case Key::Error:
        frame_.error = value;
        break;
      case Key::Fd:
        fd_ = value;
        break;
      default:
        return is_ignored();
    }
    return is_value();
  }

  bool visit_positive_integer(std::uint64_t value) noexcept {
    if (key_ == Key::Id) {
      frame_.id = static_cast<std::uint32_t>(value);
      return is_value() && value <= 0x1FFFFFFF;
    }
    if (key_ == Key::Size) {
      frame_.size = static_cast<std::uint8_t>(value);
      return is_value() && value <= 8;
    }
    return is_ignored();
  }

  bool visit_bin(const char* bytes, std::uint32_t size) noexcept {
    if (!is_value() || key_ != Key::Data || size > 8) return false;
    std::memcpy(frame_.data.data(), bytes, size);
    bytes_ = size;
    return true;
  }

  bool visit_str(const char* text, std::uint32_t size) noexcept {
    if (!is_key_) return is_ignored();
    const auto* known = std::find_if(kKeys.begin(), kKeys.end(),
                                     [&](const NamedKey& entry) { return entry.name == std::string_view(text, size); });
    if (known == kKeys.end()) return false;
    key_ = known->key;
    seen_ |= 1u << static_cast<unsigned>(key_);
    return true;
  }

  /// The frame, if what was read makes one.
  [[nodiscard]] std::optional<Frame> frame() const noexcept {
    if ((seen_ & kRequired) != kRequired || fd_) return std::nullopt;
    if (!frame_.extended && !frame_.error && frame_.id > 0x7FF) return std::nullopt;
    if (bytes_ != (frame_.remote ? 0 : frame_.size)) return std::nullopt;
    Frame out = frame_;
    if (out.error) out.extended = false;
    return out;
  }

 private:
  [[nodiscard]] bool is_value() const noexcept { return in_map_ && !is_key_; }
  [[nodiscard]] bool is_ignored() const noexcept { return is_value() && key_ == Key::Ignored; }

  Frame frame_;
  std::size_t bytes_ = 0;
  std::uint32_t seen_ = 0;
  Key key_ = Key::Ignored;
  bool in_map_ = false, is_key_ = false, fd_ = false;
};

}  // namespace

void DatagramEncoder::write(const char* data, std::size_t size) noexcept {
  const std::size_t fits = std::min(size, kCapacity - size_);
  std::memcpy(bytes_.data() + size_, data, fits);
  size_ += fits;
}

std::span<const char> DatagramEncoder::encode(const Frame& frame, double time_s) noexcept {
  size_ = 0;
  msgpack::packer<DatagramEncoder> packer(*this);
  packer.pack_map(kKeys.size());
  const auto field = [&](std::size_t k) -> msgpack::packer<DatagramEncoder>& {
    const auto size = static_cast<std::uint32_t>(kKeys[k].name.size());
    return packer.pack_str(size).pack_str_body(kKeys[k].name.data(), size);
  };
  const std::uint32_t bytes = frame.remote ? 0u : frame.size;
  field(0).pack_double(time_s);
  field(1).pack_uint32(frame.id);
  field(2).pack(frame.extended);
  field(3).pack(frame.remote);
  field(4).pack(frame.error);
  field(5).pack_nil();
  field(6).pack_uint8(frame.size);
  field(7).pack_bin(bytes).pack_bin_body(reinterpret_cast<const char*>(frame.data.data()), bytes);
  for (const std::size_t k : {8u, 9u, 10u}) field(k).pack_false();
  return {bytes_.data(), size_};
}

// The library's parse() makes its stack anew for each message, on the heap; this is the same with the stack kept.
class DatagramDecoder::Parser : public msgpack::detail::parse_helper<FrameVisitor> {
 public:
  Parser() : parse_helper(visitor_) {}

 private:
  FrameVisitor visitor_;
};

DatagramDecoder::DatagramDecoder() : parser_(std::make_unique<Parser>()) {}
DatagramDecoder::~DatagramDecoder() = default;

std::optional<Frame> DatagramDecoder::decode(std::span<const char> datagram) noexcept try {
  if (datagram.empty()) return std::nullopt;
  parser_->init();
  std::size_t used = 0;
  const auto result = parser_->execute(datagram.data(), datagram.size(), used);
  if (result != msgpack::PARSE_SUCCESS || used != datagram.size()) return std::nullopt;
  return parser_->visitor().frame();
} catch (...) {
  return std::nullopt;  // the library throws at an extension type longer than memory
}

}  // namespace glenoid::can
