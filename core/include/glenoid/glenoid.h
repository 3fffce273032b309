/* Glenoid for C and other languages: opaque handles, plain numbers, no exceptions. SI units and rad.
 * Every function may be called with any arguments: bad ones are refused with a status and a message. */
#ifndef GLENOID_H
#define GLENOID_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct glenoid_motion glenoid_motion;

/* Status numbers of glenoid/status.hpp. */
typedef enum {
  GLENOID_OK = 0, GLENOID_NOT_FINITE = 1, GLENOID_OUT_OF_RANGE = 2, GLENOID_TARGET_UNREACHABLE = 3,
  GLENOID_LIMITS_INFEASIBLE = 4, GLENOID_EXO_INFEASIBLE = 5, GLENOID_NO_CONVERGENCE = 6, GLENOID_NOT_AVAILABLE = 7
} glenoid_status;

typedef struct {
  double stature_m, mass_kg;
  int female, left_arm;
  double upper_arm_length_m, forearm_length_m, shoulder_distance_m; /* 0 = scaled from stature */
  int rhythm_model;                                                 /* 1 Fixed, 2 SoltaniZarrin2017, 3 Measured */
  double rhythm_gain, rhythm_smoothing_rad;
  int moving_shoulder;
  int swivel_mode;                                                  /* 1 MinimumEnergy, 2 Prescribed, 3 HumanPrior */
  double swivel_prescribed_rad;
  double duration_s;
  double limits_lower_rad[4], limits_upper_rad[4];                  /* theta, eta, eta + zeta, phi */
  double start_q_rad[4];                                            /* theta, eta, zeta, phi */
} glenoid_settings;

typedef struct {
  double q_rad[4], dq_rad_per_s[4], ddq_rad_per_s2[4];
  double shoulder_m[3], elbow_m[3], wrist_m[3];
  double girdle[3];                                                 /* phi_ed rad, phi_pr rad, d_SG m */
  double swivel_rad, progress, energy_kg_m2, misalignment_m;
  double exo_q_rad[6], exo_dq_rad_per_s[6];
  int status;                                                       /* MotionStatus of glenoid/motion.hpp */
} glenoid_sample;

/* Fills the settings with the defaults. */
void glenoid_default_settings(glenoid_settings* settings);
/* NULL on failure; then `message` (if not NULL, message_size bytes) says variable, value, unit and rule. */
glenoid_motion* glenoid_create(const glenoid_settings* settings, double start_time_s, char* message, size_t message_size);
void glenoid_destroy(glenoid_motion* motion);
/* Inputs that hold from time_s on. The movement's status is part of the next sample. */
glenoid_status glenoid_command(glenoid_motion* motion, double time_s, const double target_m[3], int enable, int stop);
glenoid_status glenoid_sample_at(const glenoid_motion* motion, double time_s, glenoid_sample* out);
/* One sentence about the last refused command; "" if none. Never NULL. */
const char* glenoid_message(const glenoid_motion* motion);

#ifdef __cplusplus
}
#endif
#endif
