#include "support/random.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "support/environment.hpp"

namespace glenoid::test {

Random::Random(std::uint64_t stream) : engine_(test_seed() + 0x9E3779B97F4A7C15ull * stream) {}

double Random::uniform(double lower, double upper) {
  const double unit = static_cast<double>(engine_() >> 11) * 0x1p-53;
  return lower + (upper - lower) * unit;
}

double Random::log_uniform(double lower, double upper) { return std::exp(uniform(std::log(lower), std::log(upper))); }

Vec3 Random::vector(double half_width) {
  Vec3 out;
  for (double& component : out) component = uniform(-half_width, half_width);
  return out;
}

Vec4 Random::vector4(double half_width) {
  Vec4 out;
  for (double& component : out) component = uniform(-half_width, half_width);
  return out;
}

Vec3 Random::unit_vector() {
  const double z = uniform(-1.0, 1.0), angle = uniform(-kPi, kPi);
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

Mat3 Random::rotation() {
  // Shoemake 1992: uniform on SO(3).
  const double u = uniform(0.0, 1.0), a = uniform(0.0, 2.0 * kPi), b = uniform(0.0, 2.0 * kPi);
  const double r = std::sqrt(1.0 - u), s = std::sqrt(u);
  return Eigen::Quaterniond(s * std::cos(b), r * std::sin(a), r * std::cos(a), s * std::sin(b)).toRotationMatrix();
}

Vec4 random_angles(Random& random, const AngleRange& range) {
  Vec4 q;
  q[kTheta] = random.uniform(range.theta_lower, range.theta_upper);
  q[kEta] = random.uniform(-kPi, kPi);
  q[kZeta] = random.uniform(-kPi, kPi);
  q[kPhi] = random.uniform(range.phi_lower, range.phi_upper);
  return q;
}

}  // namespace glenoid::test
