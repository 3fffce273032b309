#include "support/allocation_guard.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace glenoid::test {
namespace {

// The pointers escape through this, so that the compiler may not drop a request.
void* volatile escaped = nullptr;

TEST(AllocationGuard, SeesNothingWhereNothingIsRequested) {
  AllocationGuard guard;
  Eigen::Vector3d x(1.0, 2.0, 3.0);
  escaped = x.data();
  EXPECT_EQ(guard.allocations(), 0);
}

TEST(AllocationGuard, CountsEveryWayToTheHeap) {
  AllocationGuard guard;
  const auto number = std::make_unique<int>(1);
  escaped = number.get();
  EXPECT_EQ(guard.allocations(), 1) << "operator new";
  void* memory = std::malloc(8);
  escaped = memory;
  EXPECT_EQ(guard.allocations(), 2) << "malloc";
  memory = std::realloc(memory, 1 << 16);
  escaped = memory;
  EXPECT_EQ(guard.allocations(), 3) << "realloc";
  std::free(memory);
  const Eigen::MatrixXd dynamic = Eigen::MatrixXd::Zero(5, 5);
  escaped = const_cast<double*>(dynamic.data());
  EXPECT_EQ(guard.allocations(), 4) << "Eigen";
  void* aligned = std::aligned_alloc(64, 128);
  escaped = aligned;
  EXPECT_EQ(guard.allocations(), 5) << "aligned_alloc";
  std::free(aligned);
}

TEST(AllocationGuard, CountsFromItsOwnStart) {
  const std::string text(1000, 'x');
  escaped = const_cast<char*>(text.data());
  AllocationGuard guard;
  EXPECT_EQ(guard.allocations(), 0);
}

}  // namespace
}  // namespace glenoid::test
