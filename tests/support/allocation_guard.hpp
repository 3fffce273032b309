#pragma once

namespace glenoid::test {

/// Counts the heap requests (malloc and everything built on it) of this thread while it lives.
///
///     AllocationGuard guard;
///     planner.plan(...);
///     EXPECT_EQ(guard.allocations(), 0);
///
/// Guards may be nested: an outer one counts what an inner one does. Works with and without AddressSanitizer.
class AllocationGuard {
 public:
  AllocationGuard() noexcept;
  ~AllocationGuard();
  AllocationGuard(const AllocationGuard&) = delete;
  AllocationGuard& operator=(const AllocationGuard&) = delete;

  /// Requests since construction.
  [[nodiscard]] long allocations() const noexcept;

 private:
  long before_;
};

}  // namespace glenoid::test
