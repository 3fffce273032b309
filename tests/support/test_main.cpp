#include <gtest/gtest.h>

#include <cstdio>

#include "support/environment.hpp"

namespace {

/// Says with every failed test which seed reproduces it.
class SeedReporter : public testing::EmptyTestEventListener {
  void OnTestEnd(const testing::TestInfo& info) override {
    if (!info.result()->Failed()) return;
    std::printf("GLENOID_TEST_SEED=%llu reproduces this\n", static_cast<unsigned long long>(glenoid::test::test_seed()));
  }
};

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  testing::UnitTest::GetInstance()->listeners().Append(new SeedReporter);  // gtest owns it
  return RUN_ALL_TESTS();
}
