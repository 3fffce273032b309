#include "glenoid/subject.hpp"

#include <cmath>

#include "problems.hpp"

namespace glenoid {
namespace {

/// One row of the table: fractions of the body and of the segment's own length.
struct TableSegment {
  double length_m;  // of the table's mean person
  double mass;      // fraction of body mass
  double com;       // from the proximal joint, fraction of length
  Vec3 gyration;    // about the centre of mass (sagittal, transverse, longitudinal), fraction of length
};

struct Table {
  double stature_m;
  TableSegment upper_arm, forearm, hand;  // hand: wrist to third metacarpal
};

// de Leva 1996, J Biomech 29(9):1223-1230, table 4 (joint centres as end points).
const Table& table_of(bool female) {
  static const Table kMale = {1.741,
                              {0.2817, 0.0271, 0.5772, {0.285, 0.269, 0.158}},
                              {0.2689, 0.0162, 0.4574, {0.276, 0.265, 0.121}},
                              {0.0862, 0.0061, 0.7900, {0.628, 0.513, 0.401}}};
  static const Table kFemale = {1.735,
                                {0.2751, 0.0255, 0.5754, {0.278, 0.260, 0.148}},
                                {0.2643, 0.0138, 0.4559, {0.261, 0.257, 0.094}},
                                {0.0780, 0.0056, 0.7474, {0.531, 0.454, 0.335}}};
  return female ? kFemale : kMale;
}

constexpr double kShoulderDistanceRatio = 0.60;  // d_0/l_u: SC-GH 0.175 m over humerus 0.291 m; Chadwick 2014 (das3)

constexpr const char* kTableSource = "de Leva 1996";
constexpr const char* kGiven = "given";

/// What a user may fix of one segment.
struct SegmentGiven {
  std::string name;
  const std::optional<double>& length_m;
  const std::optional<double>& mass_kg;
  const std::optional<double>& com_m;
  const std::optional<Vec3>& inertia_kg_m2;
};

/// Equation A1: lengths with stature, masses with body mass; A2: the two transverse moments are averaged, so that the segment
/// is axisymmetric.
Segment from_table(const TableSegment& row, double stature_ratio, double body_mass_kg) {
  Segment segment;
  segment.length_m = row.length_m * stature_ratio;
  segment.mass_kg = row.mass * body_mass_kg;
  segment.com_m = row.com * segment.length_m;
  const Vec3 square = row.gyration.cwiseAbs2();
  const double transverse = 0.5 * (square[0] + square[1]);
  segment.inertia_kg_m2 = segment.mass_kg * segment.length_m * segment.length_m *
                          Vec3(transverse, transverse, square[2]);
  return segment;
}

/// Equation A3: hand in line with the forearm; transverse moments by the parallel-axis theorem, axial ones added.
Segment lumped(const Segment& forearm, const Segment& hand) {
  Segment both;
  both.length_m = forearm.length_m;
  both.mass_kg = forearm.mass_kg + hand.mass_kg;
  const double hand_com_m = forearm.length_m + hand.com_m;
  both.com_m = (forearm.mass_kg * forearm.com_m + hand.mass_kg * hand_com_m) / both.mass_kg;
  const double distance_m = hand_com_m - forearm.com_m;
  const double reduced_kg = forearm.mass_kg * hand.mass_kg / both.mass_kg;
  const double transport = reduced_kg * distance_m * distance_m;
  both.inertia_kg_m2 = forearm.inertia_kg_m2 + hand.inertia_kg_m2 + Vec3(transport, transport, 0.0);
  return both;
}

/// Equation A4: what is given replaces the table; centre of mass and gyration radii keep their fraction of the length.
Segment with_given(const Segment& scaled, const SegmentGiven& given) {
  Segment segment = scaled;
  segment.length_m = given.length_m.value_or(scaled.length_m);
  segment.mass_kg = given.mass_kg.value_or(scaled.mass_kg);
  const double stretch = segment.length_m / scaled.length_m;
  segment.com_m = given.com_m.value_or(scaled.com_m * stretch);
  const double inertia_ratio = segment.mass_kg / scaled.mass_kg * stretch * stretch;
  segment.inertia_kg_m2 = given.inertia_kg_m2.value_or(scaled.inertia_kg_m2 * inertia_ratio);
  return segment;
}

void check_inertia(Problems& problems, const std::string& name, const Vec3& inertia) {
  constexpr double kRounding = 1e-12;  // relative; a flat plate has equality
  for (Eigen::Index k = 0; k < 3; ++k) {
    const std::string axis = name + "[" + "xyz"[k] + "]";
    problems.require_positive(axis, inertia[k], "kg.m2");
    const double others = inertia.sum() - inertia[k];
    problems.require(!(inertia[k] > others * (1.0 + kRounding)), axis, inertia[k], "kg.m2",
                     "must not exceed the sum of the two other moments");
  }
}

void check_given(Problems& problems, const SegmentGiven& given, const Segment& scaled) {
  constexpr double kLongest_m = 1.0;    // beyond every person; catches millimetres and centimetres
  constexpr double kFarthestCom = 1.5;  // of the length: a hand may hold a load
  if (given.length_m) {
    problems.require(*given.length_m > 0.0 && *given.length_m <= kLongest_m, given.name + ".length", *given.length_m,
                     "m", "must be above 0 and at most 1 m; another unit in the file?");
  }
  if (given.mass_kg) problems.require_positive(given.name + ".mass", *given.mass_kg, "kg");
  if (given.com_m) {
    const double length_m = given.length_m.value_or(scaled.length_m);
    problems.require(*given.com_m > 0.0 && *given.com_m <= kFarthestCom * length_m, given.name + ".com", *given.com_m,
                     "m", "must be above 0 and at most 1.5 segment lengths");
  }
  if (given.inertia_kg_m2) check_inertia(problems, given.name + ".inertia", *given.inertia_kg_m2);
}

void report_segment(const Segment& segment, const SegmentGiven& given, const std::string& parts,
                    std::vector<ScalingEntry>& report) {
  const std::string table = std::string(kTableSource) + ", " + parts;
  const bool stretched = given.length_m.has_value();
  const std::string com = table + (stretched ? ", fraction of the given length" : ", fraction of the length");
  const std::string inertia = table + ", gyration radii averaged over the transverse axes" +
                              (stretched ? ", of the given length" : "") + (given.mass_kg ? ", of the given mass" : "");
  const auto source = [](bool is_given, const std::string& rule) { return is_given ? std::string(kGiven) : rule; };
  report.push_back({given.name + ".length", segment.length_m, "m", source(stretched, table + ", fraction of stature")});
  report.push_back({given.name + ".mass", segment.mass_kg, "kg",
                    source(given.mass_kg.has_value(), table + ", fraction of body mass")});
  report.push_back({given.name + ".com", segment.com_m, "m", source(given.com_m.has_value(), com)});
  for (Eigen::Index k = 0; k < 3; ++k) {
    report.push_back({given.name + ".inertia[" + "xyz"[k] + "]", segment.inertia_kg_m2[k], "kg.m2",
                      source(given.inertia_kg_m2.has_value(), inertia)});
  }
}

}  // namespace

ScaledArm scale_subject(const Subject& subject) {
  Problems problems;
  problems.require_range("subject.stature", subject.stature_m, 0.5, 2.6, "m");
  problems.require_range("subject.mass", subject.mass_kg, 10.0, 400.0, "kg");

  const Table& table = table_of(subject.female);
  const double ratio = subject.stature_m / table.stature_m;
  const Segment upper_arm = from_table(table.upper_arm, ratio, subject.mass_kg);
  const Segment forearm = lumped(from_table(table.forearm, ratio, subject.mass_kg),
                                 from_table(table.hand, ratio, subject.mass_kg));
  const SegmentGiven upper_given = {"upper_arm", subject.upper_arm_length_m, subject.upper_arm_mass_kg,
                                    subject.upper_arm_com_m, subject.upper_arm_inertia_kg_m2};
  const SegmentGiven fore_given = {"forearm", subject.forearm_length_m, subject.forearm_mass_kg, subject.forearm_com_m,
                                   subject.forearm_inertia_kg_m2};
  check_given(problems, upper_given, upper_arm);
  check_given(problems, fore_given, forearm);
  if (subject.shoulder_distance_m) {
    problems.require(*subject.shoulder_distance_m > 0.0 && *subject.shoulder_distance_m <= 1.0, "shoulder_distance",
                     *subject.shoulder_distance_m, "m", "must be above 0 and at most 1 m; another unit in the file?");
  }
  problems.throw_if_any();

  ScaledArm arm;
  arm.upper_arm = with_given(upper_arm, upper_given);
  arm.forearm = with_given(forearm, fore_given);
  arm.shoulder_distance_m = subject.shoulder_distance_m.value_or(kShoulderDistanceRatio * arm.upper_arm.length_m);
  const std::string person = subject.female ? "female" : "male";
  report_segment(arm.upper_arm, upper_given, person + " upper arm", arm.report);
  report_segment(arm.forearm, fore_given, person + " forearm and hand in line", arm.report);
  arm.report.push_back({"shoulder_distance", arm.shoulder_distance_m, "m",
                        subject.shoulder_distance_m ? kGiven : "0.60 of upper_arm.length (Chadwick 2014)"});
  return arm;
}

void apply_axial_factor(ScaledArm& arm, double factor) noexcept {
  for (Segment* segment : {&arm.upper_arm, &arm.forearm}) {
    arm.turning_kg_m2 += (factor - 1.0) * segment->inertia_kg_m2.z();
    segment->inertia_kg_m2.z() *= factor;
  }
}

}  // namespace glenoid
