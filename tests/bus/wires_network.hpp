#pragma once

// A network of the test's own, so that multicast of several tests at once does not mix.

#include <string>

namespace glenoid::test {

/// Moves this process into a network of its own with lo up and the multicast route on it. Call before threads start.
/// Empty if it did (or did before); otherwise why multicast cannot be used here, for GTEST_SKIP.
std::string own_network();

}  // namespace glenoid::test
