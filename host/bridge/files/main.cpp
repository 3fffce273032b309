// Writes the files that describe the process data: glenoid_mapping.dbc (nodes 1 to 6) and glenoid_mapping.eds.

#include <array>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>

#include "host/bridge/files/pdo_files.hpp"

namespace {

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file.exceptions(std::ios::failbit | std::ios::badbit);
  file << text << std::flush;
}

}  // namespace

int main(int count, char** arguments) try {
  if (count != 2) {
    std::fputs("usage: glenoid-pdo-files FOLDER\n", stderr);
    return 2;
  }
  constexpr std::array<std::uint8_t, 6> kNodes = {1, 2, 3, 4, 5, 6};
  constexpr std::uint8_t kMaster = 0x7F;
  const std::filesystem::path folder(arguments[1]);
  std::filesystem::create_directories(folder);
  write(folder / "glenoid_mapping.dbc", glenoid::bridge::dbc(kNodes, kMaster));
  write(folder / "glenoid_mapping.eds", glenoid::bridge::mapping_eds());
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "glenoid-pdo-files: %s\n", error.what());
  return 1;
}
