#include "acnhfc.h"

#include "nhfc_c_types.h"

#include <stdio.h>

static genom_event
out_of_range(const char *what, const genom_context self)
{
  nhfc_e_range_detail d;
  snprintf(d.what, sizeof d.what, "%s", what);
  return nhfc_e_range(&d, self);
}


/** Validation codel hfc_check_gains of attribute set_gains.
 *
 * Returns genom_ok.
 * Throws nhfc_e_range.
 */
genom_event
hfc_check_gains(const nhfc_ids_gains_s *gains,
                const genom_context self)
{
  const double all[] = {gains->kp_xy, gains->kp_z, gains->kv_xy, gains->kv_z, gains->kq_xy,
                        gains->kq_z,  gains->kw_xy, gains->kw_z, gains->ki_xy, gains->ki_z};
  for (unsigned i = 0; i < sizeof all / sizeof *all; i++)
    if (!(all[i] >= 0.)) return out_of_range("a gain is negative", self);
  return genom_ok;
}


/** Validation codel hfc_check_body of attribute set_body.
 *
 * Returns genom_ok.
 * Throws nhfc_e_range.
 */
genom_event
hfc_check_body(const nhfc_ids_body_s *body, const genom_context self)
{
  if (!(body->mass > 0.)) return out_of_range("mass is not positive", self);
  if (!(body->arm > 0.)) return out_of_range("arm is not positive", self);
  if (!(body->thrust > 0.)) return out_of_range("thrust is not positive", self);
  if (!(body->drag > 0.)) return out_of_range("drag is not positive", self);
  return genom_ok;
}
