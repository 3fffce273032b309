#pragma once

#include <cstdint>

namespace glenoid::test {

/// Seed of all random data: GLENOID_TEST_SEED, or a fixed number. Printed with every failure.
std::uint64_t test_seed();

/// How many random cases a test draws: GLENOID_TEST_COUNT, or what the test asks for.
int test_count(int otherwise);

}  // namespace glenoid::test
