#include "host/drives/dictionary.hpp"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string>

namespace glenoid::drives {
namespace {

constexpr std::uint16_t kErrorField = 0x1003, kFaultInjection = 0x2F00;  // what happens, not how it is set

constexpr bool table_is_sorted() {
  for (std::size_t k = 1; k < kObjects; ++k) {
    const Object &a = kObjectTable[k - 1], &b = kObjectTable[k];
    if (a.index > b.index || (a.index == b.index && a.sub >= b.sub)) return false;
  }
  return true;
}
static_assert(table_is_sorted(), "rows in order of address, each once");

std::string describe(Address address) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%04Xh:%02X", unsigned{address.index}, unsigned{address.sub});
  return text.data();
}

bool matches(Address absent, const Object& row) {
  return absent.index == row.index && (absent.sub == 0xFF || absent.sub == row.sub);
}

}  // namespace

void Text::assign(std::string_view text) noexcept {
  size = std::min(text.size(), kTextLength);
  std::copy_n(text.begin(), size, characters.begin());
}

Dictionary::Dictionary(const Profile& profile, std::uint8_t node) {
  for (std::size_t k = 0; k < kObjects; ++k) {
    const Object& row = kObjectTable[k];
    present_[k] = std::none_of(profile.absent.begin(), profile.absent.end(),
                               [&row](Address address) { return matches(address, row); });
    defaults_[k] = row.value + (row.per_node ? node : 0);
  }
  for (const ObjectDefault& object : profile.objects) {
    const std::size_t k = find_row(object.address.index, object.address.sub);
    if (k == kObjects) throw std::invalid_argument(profile.name + ": no object " + describe(object.address));
    const Range range = range_of(k);
    if (object.value < range.low || object.value > range.high) {
      throw std::invalid_argument(profile.name + ": " + describe(object.address) + " = " + std::to_string(object.value) +
                                  ": must be " + std::to_string(range.low) + " to " + std::to_string(range.high));
    }
    defaults_[k] = object.value;
  }
  set_text(row_of(0x1008), profile.device_name);
  set_text(row_of(0x1009), profile.name);
  set_text(row_of(0x100A), "CiA 301 and CiA 402, csp");
  forget_stored();
  reset(false);
}

void Dictionary::store() noexcept {
  for (std::size_t k = 0; k < kObjects; ++k) {
    const Object& row = kObjectTable[k];
    const bool parameter = row.access == Access::Rw && row.mappable == Mappable::No;
    if (parameter && row.index != kErrorField && row.index != kFaultInjection) power_up_[k] = values_[k];
  }
}

void Dictionary::reset(bool communication_only) noexcept {
  for (std::size_t k = 0; k < kObjects; ++k) {
    if (!communication_only || kObjectTable[k].index < 0x2000) values_[k] = power_up_[k];
  }
}

std::size_t Dictionary::find(std::uint16_t index, std::uint8_t sub, Abort& why) const noexcept {
  const std::size_t row = find_row(index, sub);
  if (row != kObjects && present_[row]) return row;
  const std::size_t whole = find_row(index, 0);
  why = whole != kObjects && present_[whole] ? Abort::NoSubIndex : Abort::NoObject;
  return kObjects;
}

std::size_t Dictionary::text_place(std::size_t row) noexcept {
  std::size_t place = 0;
  for (std::size_t k = 0; k < row; ++k) place += kObjectTable[k].type == Type::Text ? 1U : 0U;
  return std::min(place, kTexts - 1);
}

const Text& Dictionary::text(std::size_t row) const noexcept { return texts_[text_place(row)]; }

void Dictionary::set_text(std::size_t row, std::string_view text) noexcept { texts_[text_place(row)].assign(text); }

std::size_t Dictionary::encode(std::size_t row, std::span<std::uint8_t> bytes) const noexcept {
  const Type type = kObjectTable[row].type;
  if (type == Type::Text) {
    const std::string_view characters = text(row).view();
    const std::size_t count = std::min(characters.size(), bytes.size());
    std::transform(characters.begin(), characters.begin() + static_cast<std::ptrdiff_t>(count), bytes.begin(),
                   [](char c) { return static_cast<std::uint8_t>(c); });
    return count;
  }
  const auto count = static_cast<std::size_t>(size_of(type));
  const auto value = static_cast<std::uint64_t>(values_[row]);
  for (std::size_t k = 0; k < count; ++k) bytes[k] = static_cast<std::uint8_t>(value >> (8 * k));
  return count;
}

std::int64_t Dictionary::decode(Type type, std::span<const std::uint8_t> bytes) noexcept {
  std::uint64_t value = 0;
  for (std::size_t k = 0; k < bytes.size(); ++k) value |= std::uint64_t{bytes[k]} << (8 * k);
  const auto number = static_cast<std::int64_t>(value);
  return lowest(type) < 0 && number > highest(type) ? number - (std::int64_t{1} << (8 * size_of(type))) : number;
}

}  // namespace glenoid::drives
