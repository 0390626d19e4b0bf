#include "acchase.h"

#include "chase_c_types.h"

#include <math.h>

static void
drive(double left, double right, const chase_wheels *wheels, const genom_context self)
{
  *wheels->data(self) = (chase_speeds){ left, right };
  wheels->write(self);
}


/** Codel chase_steer_start of task steer.
 *
 * Triggered by chase_start.
 * Yields to chase_pause_main.
 */
genom_event
chase_steer_start(double *speed, double *gain,
                  const chase_wheels *wheels,
                  const genom_context self)
{
  *speed = 0.2;
  *gain = 0.5;
  drive(0., 0., wheels, self);
  return chase_pause_main;
}


/** Codel chase_steer_main of task steer.
 *
 * Triggered by chase_main.
 * Yields to chase_pause_main.
 */
genom_event
chase_steer_main(double speed, double gain, const chase_ball *ball,
                 const chase_wheels *wheels, const genom_context self)
{
  const watching_sight *sight;

  ball->read(self);
  sight = ball->data(self);
  if (sight && sight->seen)
    drive(speed + gain * sight->x, speed - gain * sight->x, wheels, self);
  else
    drive(0., 0., wheels, self);
  return chase_pause_main;
}


/** Codel chase_steer_stop of task steer.
 *
 * Triggered by chase_stop.
 * Yields to chase_ether.
 */
genom_event
chase_steer_stop(const chase_wheels *wheels, const genom_context self)
{
  drive(0., 0., wheels, self);
  return chase_ether;
}


/** Codel chase_meet of activity meet.
 *
 * Triggered by chase_start.
 * Yields to chase_pause_start, chase_ether.
 */
genom_event
chase_meet(double within, const chase_ball *ball, double *x,
           const genom_context self)
{
  const watching_sight *sight;

  ball->read(self);
  sight = ball->data(self);
  if (!sight || !sight->seen || fabs(sight->x) > within) return chase_pause_start;
  *x = sight->x;
  return chase_ether;
}


/** Codel chase_meet_stop of activity meet.
 *
 * Triggered by chase_stop.
 * Yields to chase_ether.
 */
genom_event
chase_meet_stop(double *x, const genom_context self)
{
  (void)self;
  *x = 0.;
  return chase_ether;
}
