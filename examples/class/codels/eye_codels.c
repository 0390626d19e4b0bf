#include "aceye.h"

#include "eye_c_types.h"


/* --- Attribute set_swing ---------------------------------------------- */

/** Validation codel eye_check_swing of attribute set_swing.
 *
 * Returns genom_ok.
 * Throws eye_e_range.
 */
genom_event
eye_check_swing(double swing, const genom_context self)
{
  eye_e_range_detail why = { "swing: 0.5 s to 60 s" };

  return swing >= 0.5 && swing <= 60. ? genom_ok : eye_e_range(&why, self);
}
