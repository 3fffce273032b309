#include "glenoid/status.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace glenoid {
namespace {

TEST(Status, EveryNumberHasANameOfItsOwn) {
  std::set<std::string> names;
  for (int number = 0; number <= 7; ++number) names.insert(to_string(static_cast<Status>(number)));
  EXPECT_EQ(names.size(), 8u);
  EXPECT_EQ(names.count("Unknown"), 0u);
}

TEST(Status, AForeignNumberIsUnknownAndNotACrash) {
  EXPECT_STREQ(to_string(static_cast<Status>(8)), "Unknown");
  EXPECT_STREQ(to_string(static_cast<Status>(-1)), "Unknown");
}

TEST(Status, NumbersAreFixedForLife) {
  EXPECT_EQ(static_cast<int>(Status::Ok), 0);
  EXPECT_EQ(static_cast<int>(Status::TargetUnreachable), 3);
  EXPECT_EQ(static_cast<int>(Status::NotAvailable), 7);
  EXPECT_STREQ(to_string(Status::Ok), "Ok");
  EXPECT_STREQ(to_string(Status::TargetUnreachable), "TargetUnreachable");
}

}  // namespace
}  // namespace glenoid
