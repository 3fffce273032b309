#pragma once

#include <array>
#include <memory>

#include "glenoid/types.hpp"

namespace glenoid {

class CurveTable;

/// Shoulder-girdle rhythm: where the glenohumeral centre is, given the direction of the upper arm. Numbers fixed for life.
enum class RhythmModel : int { Fixed = 1, SoltaniZarrin2017 = 2, Measured = 3 };

/// Coefficients of RhythmModel::Measured (R5), fitted by `glenoid validate --fit`: replace them to use recordings of your own.
struct MeasuredRhythm {
  /// Displacement of the centre per unit of upper-arm direction u = -z_TU, m, rows x, y, z of T.
  std::array<double, 9> slope_m = {0.0,     0.0,    -0.0140,  //
                                   -0.0412, 0.0190, 0.0,      //
                                   0.0,     0.0,    0.0248};
  double shoulder_distance_m = 0.161;  ///< d_0 of the persons that the slope was fitted to
};

struct RhythmSettings {
  RhythmModel model = RhythmModel::SoltaniZarrin2017;
  double gain = 1.0;           ///< scales the displacement from rest; 0..1.5
  double smoothing_rad = 0.1;  ///< theta -> theta erf(theta/smoothing); 0 = the polynomial as printed; 0..0.3
  MeasuredRhythm measured{};   ///< used by Measured
};

/// Value and derivatives of the centre with respect to z_TU, the third column of R_TU (the upper arm points along -z_TU).
struct RhythmJet {
  Vec3 p_TS;                ///< glenohumeral centre in T, m
  Mat3 J_z;                 ///< d p_TS / d z_TU, m
  std::array<Mat3, 3> H_z;  ///< second derivative of each coordinate, m
};

/// Replaceable model of the glenohumeral centre (docs/equations.md, R1-R5). A value: copies are cheap and take no memory.
///
/// It is defined for every unit vector z_TU and continuous there; with smoothing > 0 it is smooth except at the arm
/// pointing straight up. It does not check that the elevation lies in the range that its source measured (0..150 deg).
class Rhythm {
 public:
  Rhythm() : Rhythm(RhythmSettings{}, 0.17) {}
  /// @param shoulder_distance_m  d_0 > 0
  /// @throws std::invalid_argument naming the setting, value, unit and rule.
  Rhythm(const RhythmSettings& settings, double shoulder_distance_m);

  /// Shifts the model so that it gives p_TS at the posture with z_TU (a measured shoulder centre).
  void anchor(const Vec3& z_TU, const Vec3& p_TS) noexcept;

  [[nodiscard]] Vec3 position(const Vec3& z_TU) const noexcept;
  /// @alloc none
  void evaluate(const Vec3& z_TU, RhythmJet& out) const noexcept;

  [[nodiscard]] const RhythmSettings& settings() const noexcept { return settings_; }

 private:
  RhythmSettings settings_;
  double shoulder_distance_m_;
  Vec3 rest_ = Vec3::Zero();  ///< centre of the hanging arm before anchoring
  Vec3 offset_ = Vec3::Zero();
  std::shared_ptr<const CurveTable> table_;  ///< of eq. (1); null: evaluated as it is. Copies share it
};

/// Girdle coordinates of a glenohumeral centre: (phi_ed rad, phi_pr rad, d_SG m); docs/equations.md, R1.
Vec3 girdle_coordinates(const Vec3& p_TS) noexcept;
/// Inverse of girdle_coordinates.
Vec3 girdle_centre(const Vec3& phi_ed_phi_pr_d) noexcept;

}  // namespace glenoid
