#include "host/drives/eds.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iterator>
#include <vector>

#include "host/drives/dictionary.hpp"

namespace glenoid::drives {
namespace {

constexpr std::uint8_t kNode = 1;  // for the dictionary's defaults; taken off again where the node id is part of them

constexpr std::uint16_t kArrays[] = {0x1003, 0x1010, 0x1011, 0x1016, 0x1029, 0x607D};  // the others are records

template <class... Arguments>
std::string format(const char* pattern, Arguments... arguments) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), pattern, arguments...);
  return text.data();
}

std::string hex(std::int64_t value) {
  return value < 0 ? std::to_string(value) : format("0x%llX", static_cast<unsigned long long>(value));
}

const char* access_word(Access access) {
  switch (access) {
    case Access::Const:
      return "const";
    case Access::Ro:
      return "ro";
    case Access::Wo:
      return "wo";
    case Access::Rw:
      return "rw";
  }
  return "";
}

std::string default_value(const Dictionary& objects, std::size_t row) {
  const Object& object = kObjectTable[row];
  if (object.type == Type::Text) return std::string(objects.text(row).view());
  const std::int64_t value = objects.get(row);
  return object.per_node ? "$NODEID+" + hex(value - kNode) : hex(value);
}

/// Fields that a variable and a sub-index share.
std::string value_fields(const Dictionary& objects, std::size_t row) {
  const Object& object = kObjectTable[row];
  const Range range = range_of(row);
  std::string text = "ParameterName=" + std::string(object.name) + "\nObjectType=0x7\n";
  text += format("DataType=0x%04X\nAccessType=%s\n", static_cast<unsigned>(object.type), access_word(object.access));
  text += "DefaultValue=" + default_value(objects, row) + "\n";
  text += format("PDOMapping=%d\n", object.mappable == Mappable::No ? 0 : 1);
  if (range.low > lowest(object.type) || range.high < highest(object.type)) {
    text += "LowLimit=" + hex(range.low) + "\nHighLimit=" + hex(range.high) + "\n";
  }
  return text + "\n";
}

std::string object_section(const Dictionary& objects, std::size_t row) {
  const Object& object = kObjectTable[row];
  const std::string index = format("%04X", unsigned{object.index});
  if (object.record.empty()) return "[" + index + "]\n" + value_fields(objects, row);
  std::string subs;
  int count = 0;
  for (std::size_t k = row; k < kObjects && kObjectTable[k].index == object.index; ++k) {
    if (!objects.has(k)) continue;
    ++count;
    subs += "[" + index + "sub" + format("%X", unsigned{kObjectTable[k].sub}) + "]\n" + value_fields(objects, k);
  }
  const bool array = std::find(std::begin(kArrays), std::end(kArrays), object.index) != std::end(kArrays);
  std::string text = "[" + index + "]\nParameterName=" + std::string(object.record) + "\n";
  text += format("ObjectType=%s\nSubNumber=%d\n\n", array ? "0x8" : "0x9", count);
  return text + subs;
}

std::string list(const char* name, const std::vector<std::uint16_t>& indices) {
  std::string text = format("[%s]\nSupportedObjects=%zu\n", name, indices.size());
  for (std::size_t k = 0; k < indices.size(); ++k) text += format("%zu=0x%04X\n", k + 1, unsigned{indices[k]});
  return text + "\n";
}

std::string head(const Profile& profile) {
  std::string text = "[FileInfo]\nFileName=" + profile.name + ".eds\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\n";
  text += "Description=" + profile.device_name + "\nCreationTime=00:00AM\nCreationDate=01-01-2025\nCreatedBy=glenoid\n";
  text += "ModificationTime=00:00AM\nModificationDate=01-01-2025\nModifiedBy=glenoid\n\n";
  text += "[DeviceInfo]\nVendorName=Glenoid\nVendorNumber=0\nProductName=" + profile.device_name + "\nProductNumber=0\n";
  text += "RevisionNumber=0\nOrderCode=0\n";
  for (const int rate : {10, 20, 50, 125, 250, 500, 800, 1000}) text += format("BaudRate_%d=1\n", rate);
  text += "SimpleBootUpMaster=0\nSimpleBootUpSlave=1\nGranularity=8\nDynamicChannelsSupported=0\nGroupMessaging=0\n";
  text += format("NrOfRXPDO=%d\nNrOfTXPDO=%d\nLSS_Supported=0\n\n[DummyUsage]\n", kPdos, kPdos);
  for (int type = 1; type <= 7; ++type) {
    text += format("Dummy%04d=%d\n", type, profile.dummy_mapping && type >= 2 ? 1 : 0);
  }
  return text + "\n[Comments]\nLines=0\n\n";
}

}  // namespace

std::string electronic_data_sheet(const Profile& profile) {
  const Dictionary objects(profile, kNode);
  std::vector<std::uint16_t> mandatory, optional, vendor;
  std::string sections;
  for (std::size_t k = 0; k < kObjects; ++k) {
    const Object& object = kObjectTable[k];
    if (object.sub != 0 || !objects.has(k)) continue;
    const bool basic = object.index == 0x1000 || object.index == 0x1001 || object.index == 0x1018;
    auto& chosen = basic ? mandatory : object.index >= 0x2000 && object.index < 0x6000 ? vendor : optional;
    chosen.push_back(object.index);
    sections += object_section(objects, k);
  }
  return head(profile) + list("MandatoryObjects", mandatory) + list("OptionalObjects", optional) +
         list("ManufacturerObjects", vendor) + sections;
}

}  // namespace glenoid::drives
