#pragma once

#include <array>
#include <optional>

#include "glenoid/path.hpp"
#include "glenoid/rhythm.hpp"
#include "glenoid/status.hpp"

namespace glenoid {

using Vec6 = Eigen::Matrix<double, 6, 1>;

/// Index of each joint in exo.q, also the order of the drives on the bus.
enum ExoJoint : int {
  kGirdleProtraction = 0,
  kGirdleElevation = 1,
  kShoulder1 = 2,
  kShoulder2 = 3,
  kShoulder3 = 4,
  kElbow = 5
};

enum class GirdleOrder : int { ProtractionFirst = 1, ElevationFirst = 2 };

/// Which drives the girdle has; a missing one leaves a residual that is reported, never hidden.
/// VerticalOnly is a vertical slide; its place is given as the elevation angle of the point it reaches (X5).
enum class GirdleDrives : int { Full = 1, NoLength = 2, VerticalOnly = 3, None = 4 };

/// The two assemblies of three intersecting axes: First has q2 = psi + C, Second q2 = psi - C (X2).
enum class ExoBranch : int { First = 1, Second = -1 };

/// A joint limit at or beyond this means none, rad.
inline constexpr double kNoExoLimit = 1e9;

/// Parameters of the device (docs/equations.md, X1-X6). Rotations are rotation vectors, rad.
struct ExoSettings {
  std::array<Vec3, 3> axes = {Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitZ()};  ///< unit, in the exo base frame at its zero
  Vec3 base = Vec3::Zero();                                                  ///< B: exo base in the thorax frame
  Vec3 cuff = Vec3::Zero();                                                  ///< C: upper arm in the last shoulder link
  GirdleOrder girdle_order = GirdleOrder::ProtractionFirst;
  GirdleDrives girdle_drives = GirdleDrives::Full;
  bool base_follows_girdle = false;  ///< the girdle rotates the shoulder axes; false: a parallelogram keeps them level
  double girdle_link_m = 0.0;        ///< fixed length used when there is no length drive; 0 = d_SG of the start posture
  double min_singularity_rad = 0.0;  ///< paths nearer to the singular set are refused; 0 = only infeasible ones
  Vec6 lower = Vec6::Constant(-kNoExoLimit);  ///< device joint limits, rad; default none
  Vec6 upper = Vec6::Constant(kNoExoLimit);
};

/// Constants of three intersecting axes (X1), derived from the settings.
struct ShoulderGeometry {
  std::array<Vec3, 3> a;         ///< unit axes in the base frame at zero
  Vec3 p3, s3;                   ///< unit, normal to a3, with a3 x p3 = s3
  Vec3 u2, v2;                   ///< unit, normal to a2: u2 towards a1, v2 = a2 x u2
  Vec3 a3_U, p3_U;               ///< C^T a3 and C^T p3: the same directions in the upper arm
  double a12, a23;               ///< angles between consecutive axes, rad
  double c23, s23;               ///< cosine and sine of a23
  double psi, cos_psi, sin_psi;  ///< q2 at which the three axes lie in one plane, a3 on the side of a1, rad
  double cos_diff, sin_diff;     ///< of (a12 - a23)/2
  double cos_sum, sin_sum;       ///< of (a12 + a23)/2
  double least, most;            ///< reachable angles between the first and the third axis, rad
};

/// Constant description of one device. A value; safe to share between threads.
class ExoModel {
 public:
  /// @param settings      the device
  /// @param p_TS_ref      glenohumeral centre at the start posture in T, m: gives the fixed link (girdle_link_m = 0) and the
  ///                      place at which missing drives stand
  /// @throws std::invalid_argument with one line per problem: variable, value, unit, rule.
  ExoModel(const ExoSettings& settings, const Vec3& p_TS_ref);

  [[nodiscard]] const ExoSettings& settings() const noexcept { return settings_; }
  [[nodiscard]] const ShoulderGeometry& shoulder() const noexcept { return shoulder_; }
  [[nodiscard]] const Mat3& R_GB() const noexcept { return R_GB_; }  ///< B: base in the girdle's last link
  [[nodiscard]] const Mat3& R_LU() const noexcept { return R_LU_; }  ///< C: upper arm in the last shoulder link
  /// Where missing drives stand, m in T.
  [[nodiscard]] const Vec3& rest_centre() const noexcept { return rest_centre_; }

 private:
  ExoSettings settings_;
  ShoulderGeometry shoulder_;
  Mat3 R_GB_, R_LU_;
  Vec3 rest_centre_;
};

/// A point with its first and second derivative, m, m/s, m/s^2.
struct PointJet {
  Vec3 p, dp, ddp;
};

/// Glenohumeral centre along a posture jet (chain rule on the rhythm). @alloc none
void shoulder_centre_jet(const Rhythm& rhythm, const PostureJet& posture, PointJet& out) noexcept;

/// Girdle coordinates (protraction rad, elevation rad, length m) of the point that the drives reach, with derivatives.
struct GirdleJet {
  Vec3 q, dq, ddq;
  double residual_m = 0.0;  ///< distance between that point and the glenohumeral centre
};

/// Girdle joints that follow the centre (X5). Finite for every finite centre; on the axis of the first joint, where its angle
/// is undefined, that angle and its rates are 0. @alloc none
void girdle_joints(const ExoModel& model, const PointJet& centre, GirdleJet& out) noexcept;

/// Base frame B in T for girdle angles, rad (X1): B alone unless the girdle carries the base.
Mat3 exo_base(const ExoModel& model, double protraction, double elevation) noexcept;

/// Forward kinematics: upper arm in T from exo.q, rad (X1).
Mat3 exo_upper_arm(const ExoModel& model, const Vec6& q) noexcept;

/// Forward kinematics: the centre of the device's shoulder in T, m, from exo.q and the girdle's length (X5).
Vec3 exo_centre(const ExoModel& model, const Vec6& q, double length_m) noexcept;

struct ShoulderSolution {
  Vec3 q = Vec3::Zero();    ///< shoulder joints 1..3, rad, within pi of near_q
  double margin_rad = 0.0;  ///< least rotation of the upper arm that reaches the edge of the feasible set; < 0 outside
  double singularity_rad = 0.0;  ///< angle of joint 2 from the nearest place where the three axes are coplanar; >= 0
  double axis_angle_rad = 0.0;   ///< between the first and the third axis
};

/// T for one posture: shoulder joints in closed form (X2, X3).
///
/// @param[in]  R_TB    base, from exo_base
/// @param[in]  R_TU    upper arm, a rotation
/// @param[in]  near_q  angles are brought within pi of it; it decides joint 1 where joints 1 and 3 share one axis
/// @param[out] out     ExoInfeasible: finite, the joints of the edge of the feasible set; NotFinite: unchanged
/// @return NotFinite, ExoInfeasible (margin below -1e-12 rad)
/// @alloc none
Status shoulder_joints(const ExoModel& model, const Mat3& R_TB, const Mat3& R_TU, ExoBranch branch, const Vec3& near_q,
                       ShoulderSolution& out) noexcept;

/// Everything about the device at one instant.
struct ExoSample {
  Vec6 q, dq, ddq;               ///< rad, rad/s, rad/s^2 (or per unit of the path parameter), order of ExoJoint
  Vec3 length_m = Vec3::Zero();  ///< the possible length coordinate of the girdle with first and second derivative
  double residual_m = 0.0;       ///< what the girdle's drives cannot reach
  double margin_rad = 0.0;       ///< as in ShoulderSolution
  double singularity_rad = 0.0;  ///< as in ShoulderSolution
  double axis_angle_rad = 0.0;   ///< between the first and the third axis
  double axis_angle_rate = 0.0;  ///< its derivative
};

/// T with first and second derivatives (X2-X6).
///
/// Within 1e-6 of the singular set the rates are those of least squares, zero in the undetermined direction.
/// @param[in]  posture  upper arm and elbow; x and z within 1e-2 of orthonormal, they are orthonormalised with their derivatives
/// @param[in]  centre   glenohumeral centre in T
/// @param[in]  near_q   shoulder joints to unwrap against, rad, from guide_angles
/// @param[out] out      ExoInfeasible: finite, the edge of the feasible set; otherwise unchanged unless Ok
/// @return NotFinite, OutOfRange (x and z are not those of a rotation), ExoInfeasible
/// @alloc none  @cost about 0.3 us
Status map_to_exo(const ExoModel& model, ExoBranch branch, const PostureJet& posture, const PointJet& centre,
                  const Vec3& near_q, ExoSample& out) noexcept;

/// Assembly and shoulder joints at the start.
struct ExoStart {
  ExoBranch branch = ExoBranch::First;
  Vec3 shoulder_q = Vec3::Zero();
  double margin_rad = 0.0;
};

/// Which branch the device starts in: the one nearest to the device's own joints where they are known; otherwise the one
/// within the joint limits, then the one with q2 in [0, pi), then First.
/// @return NotFinite, ExoInfeasible (`out` is then the edge of the feasible set)
Status choose_branch(const ExoModel& model, const Posture& posture, const Vec3& p_TS,
                     const std::optional<Vec3>& device_q, ExoStart& out) noexcept;

/// Unwrapped shoulder joints along one motion: makes exo.q a pure, continuous function of the parameter. Trivially copyable.
struct ExoGuide {
  static constexpr int kIntervals = 32;
  ExoBranch branch = ExoBranch::First;
  std::array<std::array<double, 3>, kIntervals + 1> shoulder_q{};  ///< at s = k/32, rad
};

/// Guide of a device at rest.
ExoGuide resting_guide(const ExoStart& start) noexcept;

/// Angles to unwrap against at s, clamped to [0, 1].
Vec3 guide_angles(const ExoGuide& guide, double s) noexcept;

/// Why a motion was refused; the first that applies.
enum class ExoRefusal : int { None = 0, OutOfReach = 1, Singular = 2, JointLimit = 3 };

/// Name of a joint, as in messages ("GirdleProtraction", ..., "Elbow"). Never null.
const char* exo_joint_name(int joint) noexcept;

/// What was found on the way; `at` is the parameter of each worst value.
struct ExoPathCheck {
  ExoRefusal refusal = ExoRefusal::None;
  ExoGuide guide;               ///< branch that serves (or the wanted one if none) and its unwrapped angles
  bool other_branch = false;    ///< the guide's branch is not the wanted one
  double start_step_rad = 0.0;  ///< largest distance of the shoulder joints at the start from start.shoulder_q
  double margin_rad = 0.0, margin_at = 0.0;  ///< feasibility, signed
  double singularity_rad = 0.0, singularity_at = 0.0;
  double limit_margin_rad = 0.0, limit_at = 0.0;  ///< joint limits, signed; kNoExoLimit without limits
  int limit_joint = 0;                            ///< ExoJoint
  bool limit_at_upper = false;
  double residual_m = 0.0, residual_at = 0.0;  ///< largest over the samples
  int samples = 0;                             ///< evaluations that this took
};

/// A motion over s in [0, 1]: writes posture and centre with derivatives with respect to s.
struct JetSource {
  void (*evaluate)(const void* context, double s, PostureJet& posture, PointJet& centre) noexcept = nullptr;
  const void* context = nullptr;
};

/// Whether the device can follow a whole motion (X6).
///
/// Method  cubic Hermite interpolation between samples, refined by bisection wherever it disagrees with the midpoint by more
///         than 1e-5 rad and could lower a worst value; the extremes are then evaluated exactly. Error estimate, not a proof.
///
/// @param[in]  start               branch and shoulder joints of the device before the motion
/// @param[in]  try_other_branch    the other assembly may answer where the wanted one breaks a joint limit; only for a device
///                                 that is not yet worn, for the change is a jump (see start_step_rad)
/// @return Ok, NotFinite, OutOfRange (as map_to_exo), ExoInfeasible: out of reach, nearer to the singular set than
///         min_singularity_rad, or outside a joint limit by more than 1e-9 rad; `out` says where and by how much.
/// @alloc none  @cost about 30 us
Status check_motion(const ExoModel& model, const JetSource& motion, const ExoStart& start, bool try_other_branch,
                    ExoPathCheck& out) noexcept;

/// check_motion along a path, s = lambda.
Status check_path(const ExoModel& model, const GeodesicPath& path, const Rhythm& rhythm, const ExoStart& start,
                  bool try_other_branch, ExoPathCheck& out) noexcept;

}  // namespace glenoid
