#include "acmaneuver.h"

#include "maneuver_c_types.h"

#include <math.h>

/* The last state that codels of task exec have seen: function stop has no port of its own. */
extern or_t3d_pos mv_last;


/* --- Activity goto ---------------------------------------------------- */

/** Validation codel validate_goto of activity goto.
 *
 * Returns genom_ok.
 * Throws maneuver_e_nostate.
 */
genom_event
validate_goto(double z, const genom_context self)
{
  if (!isfinite(z) || z <= 0.) return maneuver_e_nostate(self);
  return genom_ok;
}


/* --- Function stop ---------------------------------------------------- */

/** Codel get_current_position of function stop.
 *
 * Returns genom_ok.
 */
genom_event
get_current_position(double *x, double *y, double *z,
                     const genom_context self)
{
  (void)self;
  *x = mv_last.x;
  *y = mv_last.y;
  *z = mv_last.z;
  return genom_ok;
}
