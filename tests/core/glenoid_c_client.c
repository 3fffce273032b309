/* A whole reach in C: the header must be C, and the library must need nothing from the caller but these calls. */
#include "glenoid/glenoid.h"

int glenoid_reach_from_c(void);

/* 0 = the wrist arrived within a micrometre of the target; otherwise the number of the step that failed. */
int glenoid_reach_from_c(void) {
  const double target_m[3] = {0.20, 0.42, 0.25};
  glenoid_settings settings;
  glenoid_sample sample;
  glenoid_motion* motion;
  double error2 = 0.0;
  int k;
  glenoid_default_settings(&settings);
  motion = glenoid_create(&settings, 0.0, NULL, 0);
  if (motion == NULL) return 1;
  if (glenoid_command(motion, 0.0, target_m, 1, 0) != GLENOID_OK) return 2;
  if (glenoid_sample_at(motion, 10.0, &sample) != GLENOID_OK) return 3;
  glenoid_destroy(motion);
  for (k = 0; k < 3; ++k) error2 += (sample.wrist_m[k] - target_m[k]) * (sample.wrist_m[k] - target_m[k]);
  return error2 < 1e-12 ? 0 : 4;
}
