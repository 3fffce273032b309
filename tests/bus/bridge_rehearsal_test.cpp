// What a rehearsal must be before the bridge arms on a real bus.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "host/bridge/report.hpp"

namespace glenoid::bridge::test {
namespace {

class Rehearsal : public testing::Test {
 protected:
  Rehearsal() { std::filesystem::create_directories(folder); }
  ~Rehearsal() override { std::filesystem::remove_all(folder); }
  Rehearsal(const Rehearsal&) = delete;
  Rehearsal& operator=(const Rehearsal&) = delete;

  /// Obstacle to arming with a configuration of hash "abc" after a rehearsal that left this file.
  [[nodiscard]] std::string obstacle(const std::string& json) const {
    std::ofstream(folder / "rehearsal.json") << json;
    return rehearsal_obstacle(folder.string(), "abc");
  }

  std::filesystem::path folder = std::filesystem::path(testing::TempDir()) /
                                 testing::UnitTest::GetInstance()->current_test_info()->name();
};

constexpr const char* kGood = R"({"verdict": "PASS", "faults": 0, "not_decided_by": [], "config_hash": "abc"})";

TEST_F(Rehearsal, PassedWithoutFaultsAndWithEveryCheckOpensTheWay) { EXPECT_EQ(obstacle(kGood), ""); }

TEST_F(Rehearsal, AnythingElseIsAnObstacleThatIsNamed) {
  const auto but = [](std::string from, const std::string& to) {
    std::string json = kGood;
    return json.replace(json.find(from), from.size(), to);
  };
  EXPECT_NE(obstacle(but("PASS", "FAIL")).find("did not pass"), std::string::npos);
  EXPECT_NE(obstacle(but("\"faults\": 0", "\"faults\": 1")).find("faults injected"), std::string::npos);
  EXPECT_NE(obstacle(but("\"faults\": 0, ", "")).find("faults injected"), std::string::npos);
  EXPECT_NE(obstacle(but("[]", "[\"following\"]")).find("did not decide"), std::string::npos);
  EXPECT_NE(obstacle(but("abc", "abd")).find("another configuration"), std::string::npos);
  EXPECT_NE(obstacle("{").find("cannot be read"), std::string::npos);
  EXPECT_NE(rehearsal_obstacle("", "abc"), "");
  EXPECT_NE(rehearsal_obstacle((folder / "none").string(), "abc"), "");
}

}  // namespace
}  // namespace glenoid::bridge::test
