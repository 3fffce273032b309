#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "glenoid/types.hpp"

namespace glenoid {

/// Rigid segment along the local -z axis: mass, centre of mass and inertia about it, in the segment's own frame.
struct Segment {
  double length_m = 0.0;
  double mass_kg = 0.0;
  double com_m = 0.0;                 ///< distance of the centre of mass from the proximal joint along -z
  Vec3 inertia_kg_m2 = Vec3::Zero();  ///< principal moments about the centre of mass (x, y, z); z is axial
};

/// What is known of a person. Absent values are scaled from stature and mass (de Leva 1996; docs/equations.md, A1-A4).
struct Subject {
  double stature_m = 1.75;
  double mass_kg = 75.0;
  bool female = false;
  bool left_arm = false;
  std::optional<double> upper_arm_length_m;
  std::optional<double> forearm_length_m;     ///< elbow to wrist centre
  std::optional<double> shoulder_distance_m;  ///< d_0, sternoclavicular joint to glenohumeral centre at rest
  std::optional<double> upper_arm_mass_kg;
  std::optional<double> forearm_mass_kg;  ///< forearm and hand together
  std::optional<double> upper_arm_com_m;
  std::optional<double> forearm_com_m;
  std::optional<Vec3> upper_arm_inertia_kg_m2;
  std::optional<Vec3> forearm_inertia_kg_m2;
};

/// One line of the scaling report: which figure came from where.
struct ScalingEntry {
  std::string name;  ///< for example "upper_arm.length"
  double value = 0.0;
  std::string unit;    ///< "m", "kg", "kg.m2"
  std::string source;  ///< "given" or the table and the rule that produced it
};

struct ScaledArm {
  Segment upper_arm;
  Segment forearm;  ///< forearm with the hand in line, lumped
  double shoulder_distance_m = 0.0;
  double turning_kg_m2 = 0.0;  ///< cost of turning in the metric, see apply_axial_factor
  std::vector<ScalingEntry> report;
};

/// Segment data of a person.
///
/// Equation  A1-A4: de Leva 1996 fractions of stature and mass; hand lumped in line with the forearm; d_0 = 0.60 l_u.
/// A given length rescales the scaled centre of mass and gyration radii of that segment with it.
///
/// @throws std::invalid_argument naming the field, its value, its unit and the broken rule (stature 0.5..2.6 m, mass
///         10..400 kg, lengths and inertias finite and > 0, inertias fulfil the triangle inequality).
ScaledArm scale_subject(const Subject& subject);

/// Makes turning about the segments' own axes dearer in the metric, in place (docs/equations.md, M5, M6): the axial inertias times
/// `factor`, and their growth as the weight of turning against the vertical. @param factor  1..5; 1 changes nothing
void apply_axial_factor(ScaledArm& arm, double factor) noexcept;

}  // namespace glenoid
