#include "snapshot.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace glenoid::fmu {
namespace {

constexpr char kMagic[] = "GLENOID";    // 8 bytes with the final zero
constexpr std::uint64_t kFormat = 2;    // raise when the list of fields below changes
constexpr std::size_t kHeader = 4 * 8;  // magic, format, payload length, checksum

/// FNV-1a, 64 bit.
std::uint64_t checksum(const unsigned char* bytes, std::size_t size) noexcept {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 0x100000001b3U;
  return hash;
}

void put_word(unsigned char* bytes, std::uint64_t word) noexcept {
  for (int k = 0; k < 8; ++k) bytes[k] = static_cast<unsigned char>(word >> (8 * k) & 0xffU);
}

std::uint64_t get_word(const unsigned char* bytes) noexcept {
  std::uint64_t word = 0;
  for (int k = 0; k < 8; ++k) word |= static_cast<std::uint64_t>(bytes[k]) << (8 * k);
  return word;
}

/// Counts words only.
struct Counter {
  std::size_t words = 0;
  template <class Number>
  void operator()(Number&) noexcept {
    ++words;
  }
};

/// Every number takes eight bytes: doubles as their bits, the others as signed whole numbers.
struct Writer {
  unsigned char* bytes;
  void operator()(const double& value) noexcept {
    std::uint64_t word = 0;
    std::memcpy(&word, &value, sizeof word);
    put_word(bytes, word);
    bytes += 8;
  }
  template <class Number>
  void operator()(const Number& value) noexcept {
    put_word(bytes, static_cast<std::uint64_t>(static_cast<std::int64_t>(value)));
    bytes += 8;
  }
};

struct Reader {
  const unsigned char* bytes;
  const unsigned char* end;
  bool good = true;

  std::uint64_t next() noexcept {
    if (end - bytes < 8) {
      good = false;
      return 0;
    }
    bytes += 8;
    return get_word(bytes - 8);
  }
  void operator()(double& value) noexcept {
    const std::uint64_t word = next();
    std::memcpy(&value, &word, sizeof value);
  }
  template <class Number>
  void operator()(Number& value) noexcept {
    value = static_cast<Number>(static_cast<std::int64_t>(next()));
  }
};

template <class Visitor, class Member>
void visit_member(Visitor& visit, Member& member) noexcept;

template <class Visitor, class... Members>
void visit_all(Visitor& visit, Members&... members) noexcept {
  (visit_member(visit, members), ...);
}

/// Nodes and coefficients beyond the order are never read, so they are not part of the state.
template <class Visitor, class Path>
void visit_path(Visitor& visit, Path& path) noexcept {
  auto& [order, energy, lift, nodes, legendre] = path;
  visit_all(visit, order, energy, lift);
  const int last = std::clamp(order, 0, kMaxPathOrder);
  for (std::size_t k = 0; k <= static_cast<std::size_t>(last); ++k) {
    visit_all(visit, nodes[k].R_TU, nodes[k].phi);
    for (std::size_t channel = 0; channel < GeodesicPath::kChannels; ++channel) visit(legendre[k][channel]);
  }
}

/// The lists of names are complete: a member that is added to a type without being added here does not compile.
template <class Visitor, class Member>
void visit_member(Visitor& visit, Member& member) noexcept {
  using Type = std::remove_const_t<Member>;
  if constexpr (std::is_arithmetic_v<Type> || std::is_enum_v<Type>) {
    visit(member);
  } else if constexpr (std::is_same_v<Type, GeodesicPath>) {
    visit_path(visit, member);
  } else if constexpr (std::is_same_v<Type, HandClock>) {
    auto& [legendre] = member;
    visit_all(visit, legendre);
  } else if constexpr (std::is_same_v<Type, ExoGuide>) {
    auto& [branch, shoulder_q] = member;
    visit_all(visit, branch, shoulder_q);
  } else if constexpr (std::is_same_v<Type, LimitMargin>) {
    auto& [margin, angle, at_upper] = member;
    visit_all(visit, margin, angle, at_upper);
  } else if constexpr (std::is_same_v<Type, LimitViolation>) {
    auto& [any, worst, lambda] = member;
    visit_all(visit, any, worst, lambda);
  } else if constexpr (std::is_same_v<Type, Certificate>) {
    auto& [step, gradient, positive, tail, variation, hand, transversality, at_limit, angle, long_way, order,
           iterations, limits] = member;
    visit_all(visit, step, gradient, positive, tail, variation, hand, transversality, at_limit, angle, long_way, order,
              iterations, limits);
  } else {
    for (auto k = member.size() * 0; k < member.size(); ++k) visit_member(visit, member.data()[k]);  // array or matrix
  }
}

template <class Visitor, class Motion>
void visit_motion(Visitor& visit, Motion& motion) noexcept {
  auto& [move_time, duration, next_duration, stop_time, stop_duration, fade_duration, fade_share, moving, stopping,
         rest_status, target_known, refused, hand_timing, target, refused_target, fade_w, fade_dw, fade_dphi,
         fade_ddphi, guide_q, hand_clock, exo_guide, path, certificate] = motion;
  visit_all(visit, move_time, duration, next_duration, stop_time, stop_duration, fade_duration, fade_share, moving,
            stopping, rest_status, target_known, refused, hand_timing, target, refused_target, fade_w, fade_dw,
            fade_dphi, fade_ddphi, guide_q, hand_clock, exo_guide, path, certificate);
}

template <class Visitor, class Shot>
void visit_snapshot(Visitor& visit, Shot& snapshot) noexcept {
  auto& [phase, stop_defined, has_motion, inputs_changed, start_time, stop_time, time, values, motion] = snapshot;
  visit_all(visit, phase, stop_defined, has_motion, inputs_changed, start_time, stop_time, time);
  visit_all(visit, values);
  if (has_motion) visit_motion(visit, motion);
}

/// Ties a state to the list of variables that it was written with.
std::uint64_t format_word() noexcept {
  return kFormat ^ checksum(reinterpret_cast<const unsigned char*>(kInstantiationToken), sizeof kInstantiationToken);
}

}  // namespace

std::size_t serialized_size(const Snapshot& snapshot) noexcept {
  Counter counter;
  visit_snapshot(counter, snapshot);
  return kHeader + 8 * counter.words;
}

void serialize(const Snapshot& snapshot, unsigned char* bytes) noexcept {
  const std::size_t payload = serialized_size(snapshot) - kHeader;
  Writer writer{bytes + kHeader};
  visit_snapshot(writer, snapshot);
  std::memcpy(bytes, kMagic, 8);
  put_word(bytes + 8, format_word());
  put_word(bytes + 16, payload);
  put_word(bytes + 24, checksum(bytes + kHeader, payload));
}

const char* deserialize(const unsigned char* bytes, std::size_t size, Snapshot& out) noexcept {
  if (size < kHeader || std::memcmp(bytes, kMagic, 8) != 0) return "not a state of Glenoid";
  if (get_word(bytes + 8) != format_word()) return "written by another version of Glenoid";
  const std::uint64_t payload = get_word(bytes + 16);
  if (payload > size - kHeader) return "truncated";
  const std::size_t length = static_cast<std::size_t>(payload);
  if (get_word(bytes + 24) != checksum(bytes + kHeader, length)) return "damaged: the checksum does not match";
  Reader reader{bytes + kHeader, bytes + kHeader + length};
  visit_snapshot(reader, out);
  const bool in_range = out.phase <= Phase::Terminated && out.motion.path.order >= 0 &&
                        out.motion.path.order <= kMaxPathOrder;
  return reader.good && reader.bytes == reader.end && in_range ? nullptr : "damaged: fields out of range";
}

}  // namespace glenoid::fmu
