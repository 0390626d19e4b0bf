#include "acpom.h"

#include "pom_c_types.h"

#include <stdio.h>


/** Validation codel pom_check_noise of attribute set_process_noise.
 *
 * Returns genom_ok.
 * Throws pom_e_range.
 */
genom_event
pom_check_noise(const pom_ids_process_noise_s *process_noise,
                const genom_context self)
{
  if (!(process_noise->jerk > 0.) || !(process_noise->angular_jerk > 0.)) {
    pom_e_range_detail d;
    snprintf(d.what, sizeof d.what, "process noise that is not positive");
    return pom_e_range(&d, self);
  }
  return genom_ok;
}
