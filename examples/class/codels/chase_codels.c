#include "acchase.h"

#include "chase_c_types.h"


/** Validation codel chase_check_speed of attribute set_speed.
 *
 * Returns genom_ok.
 * Throws chase_e_range.
 */
genom_event
chase_check_speed(double speed, const genom_context self)
{
  chase_e_range_detail why = { "speed: 0 to 1 m/s" };

  return speed >= 0. && speed <= 1. ? genom_ok : chase_e_range(&why, self);
}
