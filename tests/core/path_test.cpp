// Interpolation and sampling of paths: evaluate_path against the rotation it interpolates, and derivatives against differences.
#include "glenoid/path.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "glenoid/kinematics.hpp"
#include "path_probe.hpp"
#include "support/allocation_guard.hpp"

namespace glenoid::test {
namespace {

/// Legendre-Gauss-Lobatto nodes on [0, 1]: the ends and the zeros of P_N', by bisection on sign changes of P_(N+1) - P_(N-1),
/// which vanishes there.
double lobatto_function(int n, double x) {
  double p0 = 1.0, p1 = x;
  for (int k = 2; k <= n; ++k) {
    const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
    p0 = p1;
    p1 = p2;
  }
  const double next = ((2 * n + 1) * x * p1 - n * p0) / (n + 1);
  return next - p0;
}

std::vector<double> lobatto_nodes(int n) {
  std::vector<double> out = {0.0};
  constexpr int kCells = 4000;
  for (int i = 0; i < kCells; ++i) {
    // Cells in the angle, since the nodes crowd at the ends; the ends themselves are zeros and are left out.
    double low = -std::cos(kPi * (i + 0.37) / (kCells + 1)), high = -std::cos(kPi * (i + 1.37) / (kCells + 1));
    double at_low = lobatto_function(n, low);
    if ((at_low < 0.0) == (lobatto_function(n, high) < 0.0)) continue;
    for (int it = 0; it < 60; ++it) {
      const double middle = 0.5 * (low + high);
      const double value = lobatto_function(n, middle);
      ((value < 0.0) == (at_low < 0.0) ? low : high) = middle;
    }
    out.push_back(0.25 * (low + high) + 0.5);
  }
  out.push_back(1.0);
  return out;
}

/// Turns about a fixed body axis with a non-uniform angle, while the elbow follows a cubic.
Posture turning(double lambda) {
  const double angle = 1.2 * lambda + 0.3 * std::sin(2.0 * lambda);
  return {posture_deg(30.0, -40.0, 10.0, 0.0).R_TU * rotation(angle * Vec3(0.48, -0.6, 0.64)),
          0.3 + lambda * lambda * (1.0 - 0.5 * lambda)};
}

GeodesicPath turning_path(int order) {
  GeodesicPath path;
  path.order = order;
  const std::vector<double> nodes = lobatto_nodes(order);
  EXPECT_EQ(nodes.size(), static_cast<std::size_t>(order) + 1);
  for (std::size_t k = 0; k < nodes.size(); ++k) path.nodes[k] = turning(nodes[k]);
  finish_path(path);
  return path;
}

class PathOrder : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Grids, PathOrder, testing::Values(6, 8, 12, 16, 20, 24, 32, 40, 48, 64));

TEST_P(PathOrder, PassesThroughItsNodes) {
  const GeodesicPath path = turning_path(GetParam());
  const std::vector<double> nodes = lobatto_nodes(GetParam());
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    PostureJet jet;
    evaluate_path(path, nodes[k], jet);
    EXPECT_LT((jet.x - path.nodes[k].R_TU.col(0)).norm() + (jet.z - path.nodes[k].R_TU.col(2)).norm(), 2e-13) << k;
    EXPECT_NEAR(jet.phi, path.nodes[k].phi, 1e-13) << k;
  }
}

TEST_P(PathOrder, ConvergesSpectrallyToWhatItInterpolates) {
  const GeodesicPath path = turning_path(GetParam());
  // Interpolation of an entire function on an interval of half-width 1/2: |f^(N+1)| (1/4)^(N+1) 2 / (N+1)!, with derivatives that
  // grow by at most the rate of turning (1.2 + 0.6) plus that of the sine inside (2) per order.
  const double error = 20.0 * std::pow(3.8 / 4.0, GetParam() + 1) / std::tgamma(GetParam() + 2.0) + 1e-12;
  for (const double lambda : {0.03, 0.21, 0.5, 0.77, 0.96}) {
    EXPECT_LT(posture_distance(path_posture(path, lambda), turning(lambda)), error) << lambda;
  }
}

TEST_P(PathOrder, HasTheDerivativesOfItsOwnValues) {
  const GeodesicPath path = turning_path(GetParam());
  constexpr double
      h = 1e-5;  // central differences: truncation h^2 f'''/6 < 1e-9, rounding 1e-15/h < 1e-9 with f''' of order 10
  for (const double lambda : {0.1, 0.45, 0.9}) {
    PostureJet low, middle, high;
    evaluate_path(path, lambda - h, low);
    evaluate_path(path, lambda, middle);
    evaluate_path(path, lambda + h, high);
    EXPECT_LT(((high.x - low.x) / (2.0 * h) - middle.dx).norm(), 2e-9);
    EXPECT_LT(((high.dx - low.dx) / (2.0 * h) - middle.ddx).norm(), 2e-8);
    EXPECT_LT(((high.z - low.z) / (2.0 * h) - middle.dz).norm(), 2e-9);
    EXPECT_LT(((high.dz - low.dz) / (2.0 * h) - middle.ddz).norm(), 2e-8);
    EXPECT_NEAR((high.phi - low.phi) / (2.0 * h), middle.dphi, 2e-9);
    EXPECT_NEAR((high.dphi - low.dphi) / (2.0 * h), middle.ddphi, 2e-8);
  }
}

TEST(Path, GivesExactRotations) {
  const GeodesicPath path = turning_path(6);  // coarse, so that the interpolated columns are not orthonormal
  for (int i = 0; i <= 50; ++i) {
    const Mat3 R = path_posture(path, i / 50.0).R_TU;
    EXPECT_LT((R.transpose() * R - Mat3::Identity()).norm(), 1e-15 * 10.0);
    EXPECT_NEAR(R.determinant(), 1.0, 1e-14);
  }
}

TEST(Path, IsClampedToItsEnds) {
  const GeodesicPath path = turning_path(16);
  EXPECT_LT(posture_distance(path_posture(path, -0.5), turning(0.0)), 1e-12);
  EXPECT_LT(posture_distance(path_posture(path, 1.5), turning(1.0)), 1e-12);
}

TEST(Path, ConstantOneStays) {
  const Posture posture = posture_deg(0.0, 30.0, 10.0, 20.0);
  GeodesicPath path;
  make_constant_path(posture, path);
  EXPECT_EQ(path.order, 0);
  EXPECT_EQ(path.energy, 0.0);
  PostureJet jet;
  for (const double lambda : {0.0, 0.4, 1.0}) {
    evaluate_path(path, lambda, jet);
    EXPECT_EQ(posture_distance(posture_of(jet), posture), 0.0);
    EXPECT_EQ(
        jet.dx.norm() + jet.dz.norm() + jet.ddx.norm() + jet.ddz.norm() + std::abs(jet.dphi) + std::abs(jet.ddphi), 0.0);
  }
}

TEST(Path, SamplingAllocatesNothing) {
  const GeodesicPath path = turning_path(64);
  PostureJet jet;
  Vec4 q, dq, ddq;
  const AllocationGuard guard;
  evaluate_path(path, 0.3, jet);
  angles_from_jet(jet, Vec4::Zero(), q, dq, ddq);
  const Posture posture = path_posture(path, 0.3);
  const long allocations = guard.allocations();
  EXPECT_EQ(allocations, 0);
  EXPECT_GT(posture.phi, 0.0);
}

TEST(AnglesFromJet, AgreeWithThePostureAndWithTheirOwnDifferences) {
  const GeodesicPath path = turning_path(40);
  constexpr double h = 1e-5;
  for (const double lambda : {0.1, 0.35, 0.6, 0.85}) {
    Vec4 q[3], dq[3], ddq[3];
    for (const int i : {0, 1, 2}) {
      PostureJet jet;
      evaluate_path(path, lambda + (i - 1) * h, jet);
      angles_from_jet(jet, Vec4::Zero(), q[i], dq[i], ddq[i]);
    }
    EXPECT_LT(posture_distance(posture_from_angles(q[1]), path_posture(path, lambda)), 1e-12);
    EXPECT_LT((q[1] - angles_from_posture(path_posture(path, lambda), Vec4::Zero())).norm(), 1e-12);
    EXPECT_LT(((q[2] - q[0]) / (2.0 * h) - dq[1]).norm(), 2e-8 * (1.0 + ddq[1].norm()));
    EXPECT_LT(((dq[2] - dq[0]) / (2.0 * h) - ddq[1]).norm(), 2e-8 * (1.0 + ddq[1].norm()));
  }
}

/// Path that starts exactly at (or just beside) the pole and leaves it with a known direction.
PostureJet leaving_the_pole(double theta, double rate) {
  const double eta = 0.4;
  const Mat3 R = posture_from_angles(Vec4(theta, eta, -0.1, 0.5)).R_TU;
  const Vec3 w = rate * Vec3(std::cos(-0.1), -std::sin(-0.1), 0.0);  // body rate of theta' alone
  PostureJet jet;
  const Mat3 dR = R * skew(w), ddR = dR * skew(w);
  jet.x = R.col(0), jet.dx = dR.col(0), jet.ddx = ddR.col(0);
  jet.z = R.col(2), jet.dz = dR.col(2), jet.ddz = ddR.col(2);
  jet.phi = 0.5, jet.dphi = 0.2, jet.ddphi = -0.1;
  return jet;
}

class NearPole : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Elevations, NearPole, testing::Values(0.0, 1e-12, 1e-8, 1e-5, 1e-3, kPi - 1e-3, kPi - 1e-8));

TEST_P(NearPole, AnglesStayFiniteAndGiveThePosture) {
  const PostureJet jet = leaving_the_pole(GetParam(), 1.0);
  Vec4 q, dq, ddq;
  angles_from_jet(jet, Vec4(0.0, 1.1, 0.2, 0.0), q, dq, ddq);
  EXPECT_TRUE(q.allFinite() && dq.allFinite() && ddq.allFinite());
  EXPECT_LT(posture_distance(posture_from_angles(q), posture_of(jet)), 2e-8);
  EXPECT_NEAR(dq[kTheta], 1.0, 1e-6);  // moving away from the pole along a meridian
}

TEST(AnglesFromJet, AtTheHangingArmKeepThePlaneAndCarryTheAxialRotation) {
  const PostureJet jet = leaving_the_pole(0.0, 0.0);
  Vec4 q, dq, ddq;
  angles_from_jet(jet, Vec4(0.0, 1.1, -0.7, 0.0), q, dq, ddq);
  EXPECT_EQ(q[kTheta], 0.0);
  EXPECT_EQ(q[kEta], 1.1);
  EXPECT_NEAR(q[kEta] + q[kZeta], 0.3, 1e-12);
}

TEST(AnglesFromJet, AreBroughtNearToWhatWasAskedFor) {
  const PostureJet jet = leaving_the_pole(0.8, 1.0);
  Vec4 q, dq, ddq;
  for (const double turns : {-2.0, -1.0, 1.0, 3.0}) {
    const Vec4 near_q = Vec4(0.8, 0.4, -0.1, 0.5) + turns * 2.0 * kPi * Vec4(0.0, 1.0, -1.0, 0.0);
    angles_from_jet(jet, near_q, q, dq, ddq);
    EXPECT_LT((q - near_q).norm(), 1e-12) << turns;
  }
}

}  // namespace
}  // namespace glenoid::test
