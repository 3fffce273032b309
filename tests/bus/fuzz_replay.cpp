// In place of libFuzzer: every file of the given folders once, and each cut and damaged in every byte.

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

namespace {

/// A copy of exactly this size, so that a sanitizer sees a read behind it.
void run(const std::vector<std::uint8_t>& bytes, std::size_t size) {
  const std::vector<std::uint8_t> exact(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
  LLVMFuzzerTestOneInput(exact.data(), exact.size());
}

void run_all(std::vector<std::uint8_t> bytes) {
  for (std::size_t size = 0; size <= bytes.size(); ++size) run(bytes, size);
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    const std::uint8_t kept = bytes[k];
    for (const unsigned other : {0x00u, 0x7Fu, 0x80u, 0xFFu, kept ^ 1u, kept + 1u}) {
      bytes[k] = static_cast<std::uint8_t>(other);
      run(bytes, bytes.size());
    }
    bytes[k] = kept;
  }
}

}  // namespace

int main(int count, char** arguments) {
  int files = 0;
  for (int k = 1; k < count; ++k) {
    if (arguments[k][0] == '-') continue;  // options of libFuzzer
    for (const auto& entry : std::filesystem::directory_iterator(arguments[k])) {
      std::ifstream file(entry.path(), std::ios::binary);
      run_all({std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()});
      ++files;
    }
  }
  std::printf("%d files\n", files);
  return files > 0 ? 0 : 1;
}
