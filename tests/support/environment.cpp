#include "support/environment.hpp"

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace glenoid::test {
namespace {

std::uint64_t number_from(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  if (text == nullptr || *text == '\0') return otherwise;
  std::size_t used = 0;
  const std::uint64_t value = std::stoull(text, &used);
  if (text[used] != '\0') throw std::invalid_argument(std::string(name) + " = " + text + ": not a whole number");
  return value;
}

}  // namespace

std::uint64_t test_seed() { return number_from("GLENOID_TEST_SEED", 20171206); }

int test_count(int otherwise) {
  return static_cast<int>(number_from("GLENOID_TEST_COUNT", static_cast<std::uint64_t>(otherwise)));
}

}  // namespace glenoid::test
