#include "host/bridge/files/pdo_files.hpp"

#include <array>
#include <cmath>
#include <cstdio>

#include "host/bridge/core/pdo_table.hpp"

namespace glenoid::bridge {
namespace {

template <class... Arguments>
std::string format(const char* pattern, Arguments... arguments) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), pattern, arguments...);
  return text.data();
}

std::string word(std::string_view text) { return std::string(text); }

/// " SG_ name : start|bits@1+ (1,0) [low|high] "unit" receiver": little endian, counts as they are.
std::string signal(const PdoEntry& entry, unsigned start_bit, const std::string& receiver) {
  const double span = std::ldexp(1.0, entry.bits), low = entry.is_signed ? -0.5 * span : 0.0;
  return format(" SG_ %s : %u|%u@1%c (1,0) [%.0f|%.0f] \"%s\" %s\n", word(entry.name).c_str(), start_bit,
                unsigned{entry.bits}, entry.is_signed ? '-' : '+', low, low + span - 1.0, word(entry.unit).c_str(),
                receiver.c_str());
}

std::string message(std::uint32_t id, const std::string& name, unsigned bytes, const std::string& sender) {
  return format("\nBO_ %u %s: %u %s\n", id, name.c_str(), bytes, sender.c_str());
}

std::string pdo_message(const Pdo& pdo, std::uint8_t node) {
  const std::string drive = format("Drive%u", unsigned{node});
  std::string text = message(pdo.cob_id + node, word(pdo.name) + "_" + drive, pdo.bytes(),
                             pdo.receive ? "Master" : drive);
  unsigned bit = 0;
  for (const PdoEntry& entry : pdo.entries) {
    text += signal(entry, bit, pdo.receive ? drive : "Master");
    bit += entry.bits;
  }
  return text;
}

std::string heartbeat(std::uint8_t node, const std::string& name) {
  return message(0x700u + node, "Heartbeat_" + name, 1, name) +
         signal({0, 0, 8, false, "nmt_state", ""}, 0, "Vector__XXX");
}

unsigned data_type(const PdoEntry& entry) {  // CiA 301, table 44
  const bool is_signed = entry.is_signed;
  switch (entry.bits) {
    case 8:
      return is_signed ? 0x2u : 0x5u;
    case 16:
      return is_signed ? 0x3u : 0x6u;
    default:
      return is_signed ? 0x4u : 0x7u;
  }
}

struct Variable {
  unsigned type;
  const char* access;
  std::string value;
  bool mappable;
};

std::string variable(const std::string& section, const std::string& name, const Variable& as) {
  return format("[%s]\nParameterName=%s\nObjectType=0x7\nDataType=0x%04X\n", section.c_str(), name.c_str(), as.type) +
         format("AccessType=%s\nDefaultValue=%s\nPDOMapping=%d\n\n", as.access, as.value.c_str(), as.mappable ? 1 : 0);
}

std::string record(unsigned index, const std::string& name, unsigned subs) {
  return format("[%04X]\nParameterName=%s\nObjectType=0x9\nSubNumber=%u\n\n", index, name.c_str(), subs);
}

std::string number(unsigned value) { return format("0x%X", value); }

std::string communication(const Pdo& pdo) {
  const std::string index = format("%04X", unsigned{pdo.communication}), name = word(pdo.name);
  return record(pdo.communication, name + " communication parameter", 3) +
         variable(index + "sub0", "highest sub-index", {0x5, "ro", "0x2", false}) +
         variable(index + "sub1", name + " COB-ID", {0x7, "rw", format("$NODEID+0x%X", pdo.cob_id), false}) +
         variable(index + "sub2", name + " transmission type", {0x5, "rw", number(pdo.transmission), false});
}

std::string mapping(const Pdo& pdo) {
  const std::string index = format("%04X", unsigned{pdo.mapping});
  const auto count = static_cast<unsigned>(pdo.entries.size());
  std::string text = record(pdo.mapping, word(pdo.name) + " mapping parameter", count + 1);
  text += variable(index + "sub0", "number of mapped objects", {0x5, "rw", number(count), false});
  for (unsigned k = 0; k < count; ++k) {
    const std::string section = index + format("sub%u", k + 1);
    text += variable(section, word(pdo.entries[k].name), {0x7, "rw", format("0x%08X", pdo.entries[k].mapping()), false});
  }
  return text;
}

std::string list(const char* name, std::span<const unsigned> indices) {
  std::string text = format("[%s]\nSupportedObjects=%zu\n", name, indices.size());
  for (std::size_t k = 0; k < indices.size(); ++k) text += format("%zu=0x%04X\n", k + 1, indices[k]);
  return text + "\n";
}

std::string head() {
  std::string text =
      "[FileInfo]\nFileName=glenoid_mapping.eds\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\n"
      "Description=Process data as glenoid-bridge maps them\nCreationTime=00:00AM\nCreationDate=01-01-2025\n"
      "CreatedBy=glenoid\nModificationTime=00:00AM\nModificationDate=01-01-2025\nModifiedBy=glenoid\n\n"
      "[DeviceInfo]\nVendorName=\nVendorNumber=0\nProductName=CiA 402 drive\nProductNumber=0\nRevisionNumber=0\n"
      "OrderCode=0\n";
  for (const int rate : {10, 20, 50, 125, 250, 500, 800, 1000}) text += format("BaudRate_%d=1\n", rate);
  text += "SimpleBootUpMaster=0\nSimpleBootUpSlave=1\nGranularity=8\nDynamicChannelsSupported=0\nGroupMessaging=0\n";
  text += "NrOfRXPDO=1\nNrOfTXPDO=1\nLSS_Supported=0\n\n[DummyUsage]\n";
  for (int type = 1; type <= 7; ++type) text += format("Dummy%04d=0\n", type);
  return text + "\n[Comments]\nLines=0\n\n";
}

std::string identity() {
  return variable("1000", "device type", {0x7, "ro", "0x00020192", false}) +
         variable("1001", "error register", {0x5, "ro", "0x0", false}) + record(0x1018, "identity object", 2) +
         variable("1018sub0", "highest sub-index", {0x5, "ro", "0x1", false}) +
         variable("1018sub1", "vendor id", {0x7, "ro", "0x0", false});
}

}  // namespace

std::string dbc(std::span<const std::uint8_t> nodes, std::uint8_t master_id) {
  std::string text = "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: Master";
  for (const std::uint8_t node : nodes) text += format(" Drive%u", unsigned{node});
  text += "\n";
  text += message(0x080, "SYNC", 0, "Master");
  for (const Pdo& pdo : kPdoTable) {
    for (const std::uint8_t node : nodes) text += pdo_message(pdo, node);
  }
  text += heartbeat(master_id, "Master");
  for (const std::uint8_t node : nodes) text += heartbeat(node, format("Drive%u", unsigned{node}));
  return text;
}

std::string mapping_eds() {
  constexpr std::array<unsigned, 3> kMandatory = {0x1000, 0x1001, 0x1018};
  std::array<unsigned, 32> optional{};
  std::size_t count = 0;
  std::string sections = identity();
  for (const Pdo& pdo : kPdoTable) {
    sections += communication(pdo) + mapping(pdo);
    optional[count++] = pdo.communication;
    optional[count++] = pdo.mapping;
    for (const PdoEntry& entry : pdo.entries) {
      sections += variable(format("%04X", unsigned{entry.index}), word(entry.name),
                           {data_type(entry), pdo.receive ? "rw" : "ro", "0x0", true});
      optional[count++] = entry.index;
    }
  }
  return head() + list("MandatoryObjects", kMandatory) + list("OptionalObjects", std::span(optional).first(count)) +
         list("ManufacturerObjects", {}) + sections;
}

}  // namespace glenoid::bridge
