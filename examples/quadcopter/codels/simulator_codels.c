#include "acsimulator.h"

#include "simulator_c_types.h"

#include <math.h>
#include <stdio.h>


/* --- Attribute set_wind ----------------------------------------------- */

/** Validation codel sim_check_wind of attribute set_wind.
 *
 * Returns genom_ok.
 * Throws simulator_e_range.
 */
genom_event
sim_check_wind(const or_t3d_vel *wind, const genom_context self)
{
  if (!(hypot(hypot(wind->vx, wind->vy), wind->vz) <= 10.)) {
    simulator_e_range_detail d;
    snprintf(d.what, sizeof d.what, "wind of more than 10 m/s");
    return simulator_e_range(&d, self);
  }
  return genom_ok;
}
