#include "acmikrokopter.h"

#include "mikrokopter_c_types.h"

#include <stdio.h>

#include "mikrokopter_line.h"


/** Validation codel mk_check_limits of attribute set_limits.
 *
 * Returns genom_ok.
 * Throws mikrokopter_e_range.
 */
genom_event
mk_check_limits(const mikrokopter_ids_limits_s *limits,
                const genom_context self)
{
  if (!(limits->wmin > 0.) || !(limits->wmax > limits->wmin)) {
    mikrokopter_e_range_detail d;
    snprintf(d.what, sizeof d.what, "not 0 < wmin < wmax");
    return mikrokopter_e_range(&d, self);
  }
  return genom_ok;
}


/** Validation codel mk_check_duration of activity calibrate_imu.
 *
 * Returns genom_ok.
 * Throws mikrokopter_e_range.
 */
genom_event
mk_check_duration(double duration, const genom_context self)
{
  if (!(duration > 0.) || duration > 60.) {
    mikrokopter_e_range_detail d;
    snprintf(d.what, sizeof d.what, "duration is not in (0, 60] s");
    return mikrokopter_e_range(&d, self);
  }
  return genom_ok;
}


/** Codel mk_stop of function stop.
 *
 * Returns genom_ok.
 */
genom_event
mk_stop(const mikrokopter_line_s *line, bool *spinning,
        const genom_context self)
{
  (void)self;
  line_send_all(line, 0.);
  *spinning = false;
  return genom_ok;
}
