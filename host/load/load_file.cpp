#include "host/load/load_file.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "host/drives/section.hpp"

namespace glenoid::load {
namespace {

using drives::Section;

Vec3 read_vector(const Section& section, const std::string& key, const Vec3& otherwise = Vec3::Zero()) {
  Vec3 value = otherwise;
  section.read_list(key, std::span(value.data(), 3));
  return value;
}

template <class Enumerator>
Enumerator read_word(const Section& section, const std::string& key,
                     std::initializer_list<std::pair<std::string_view, Enumerator>> words) {
  std::string word(words.begin()->first);
  section.read(key, word);
  std::string known;
  for (const auto& [name, value] : words) {
    if (name == word) return value;
    known.append(known.empty() ? "" : ", ").append(name);
  }
  section.fail(key + " = " + word + ": must be one of " + known);
}

Segment read_segment(const Section& section) {
  section.allow_only({"length_m", "mass_kg", "com_m", "inertia_kg_m2"});
  Segment segment;
  section.read_positive("length_m", segment.length_m);
  section.read_positive("mass_kg", segment.mass_kg);
  section.read_not_negative("com_m", segment.com_m);
  segment.inertia_kg_m2 = read_vector(section, "inertia_kg_m2");
  return segment;
}

ExoSettings read_device(const Section& section) {
  section.allow_only(
      {"axis_1", "axis_2", "axis_3", "base_rad", "cuff_rad", "girdle_order", "girdle_drives", "base_follows_girdle"});
  ExoSettings exo;
  for (std::size_t k = 0; k < 3; ++k) exo.axes[k] = read_vector(section, "axis_" + std::to_string(k + 1), exo.axes[k]);
  exo.base = read_vector(section, "base_rad");
  exo.cuff = read_vector(section, "cuff_rad");
  exo.girdle_order = read_word<GirdleOrder>(
      section, "girdle_order",
      {{"ProtractionFirst", GirdleOrder::ProtractionFirst}, {"ElevationFirst", GirdleOrder::ElevationFirst}});
  exo.girdle_drives = read_word<GirdleDrives>(section, "girdle_drives",
                                              {{"Full", GirdleDrives::Full},
                                               {"NoLength", GirdleDrives::NoLength},
                                               {"VerticalOnly", GirdleDrives::VerticalOnly},
                                               {"NoDrives", GirdleDrives::None}});
  section.read("base_follows_girdle", exo.base_follows_girdle);
  return exo;
}

}  // namespace

LoadFile read_load_file(const std::filesystem::path& file) {
  const Section root = drives::read_yaml(file);
  root.allow_only({"upper_arm", "forearm", "exoskeleton", "girdle_length_m", "gravity_m_per_s2", "joints"});
  LoadFile out;
  out.settings.upper_arm = read_segment(root.section("upper_arm"));
  out.settings.forearm = read_segment(root.section("forearm"));
  out.settings.exo = read_device(root.section("exoskeleton"));
  root.read_positive("girdle_length_m", out.settings.girdle_length_m);
  root.read_not_negative("gravity_m_per_s2", out.settings.gravity_m_per_s2);
  const YAML::Node joints = root.get("joints");
  if (!joints.IsDefined() || !joints.IsSequence() || joints.size() != out.nodes.size())
    root.fail("joints: must be a list of 6, a joint of the exoskeleton each");
  for (std::size_t k = 0; k < out.nodes.size(); ++k) {
    const Section joint(joints[k], file.filename().string() + ".joints[" + std::to_string(k) + "]");
    joint.allow_only({"node", "sign", "offset_rad"});
    int node = 0;
    double sign = 1.0;
    joint.read("node", node);
    joint.read("sign", sign);
    joint.read("offset_rad", out.settings.joints[k].offset_rad);
    if (node < 1 || node > 127) joint.fail("node = " + std::to_string(node) + ": must be 1 to 127");
    if (sign != 1.0 && sign != -1.0) joint.fail("sign = " + std::to_string(sign) + ": must be 1 or -1");
    out.nodes[k] = static_cast<std::uint8_t>(node);
    out.settings.joints[k].sign = sign;
  }
  return out;
}

std::unique_ptr<ArmLoad> make_load(const LoadFile& file, const std::vector<std::uint8_t>& nodes) {
  if (!std::equal(nodes.begin(), nodes.end(), file.nodes.begin(), file.nodes.end())) {
    std::string wanted;
    for (const std::uint8_t node : file.nodes) wanted.append(wanted.empty() ? "" : ",").append(std::to_string(node));
    throw std::invalid_argument("--load: its joints are the nodes " + wanted + ", in this order: give --nodes " +
                                wanted);
  }
  return std::make_unique<ArmLoad>(file.settings);
}

}  // namespace glenoid::load
