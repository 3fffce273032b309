#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <functional>
#include <stdexcept>
#include <string>

namespace glenoid::test {

/// Largest absolute difference of two matrices of one size; for use with EXPECT_LE.
template <class A, class B>
double max_difference(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  return (a - b).cwiseAbs().maxCoeff();
}

/// EXPECT_TRUE(near(a, b, tolerance)) prints both sides on failure. NaN is never near.
template <class A, class B>
testing::AssertionResult near(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b, double tolerance) {
  const double difference = max_difference(a, b);
  if (difference <= tolerance) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "differ by " << difference << ", allowed " << tolerance << ":\n"
                                     << a << "\nand\n"
                                     << b;
}

/// Text of the std::invalid_argument that the action throws; "" if it throws none.
inline std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace glenoid::test
