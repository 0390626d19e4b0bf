/*
 * A water tank: a small component whose codels no longer follow the specification.
 */

#include "actank.h"

#include "tank_c_types.h"

/* Seeded: nobody wrote tank_drain_wait. */

/* A helper: it returns an event and takes the context, and is no codel. */
static genom_event
tank_stuck(int16_t valve, const genom_context self)
{
  tank_e_valve_detail d = { .valve = valve };
  return tank_e_valve(&d, self);
}


/* --- Task control ----------------------------------------------------- */


/** Codel tank_control_start of task control.
 *
 * Triggered by tank_start.
 * Yields to tank_main.
 * Throws tank_e_valve.
 */
genom_event
tank_control_start(tank_reading *last, int32_t *cycles,
                   const genom_context self)
{
  (void)self;
  last->level = 0.;
  last->valve = tank_CLOSED;
  *cycles = 0;
  return tank_main;
}


/** Codel tank_control_main of task control.
 *
 * Triggered by tank_main.
 * Yields to tank_pause_main, tank_stop.
 * Throws tank_e_valve.
 */
/* Seeded: it never returns tank_stop. */
genom_event
tank_control_main(double setpoint, double gain, tank_reading *last,
                  const tank_state *state, const genom_context self)
{
  tank_reading *out = state->data(self);

  if (out == NULL) return tank_stuck(0, self);
  last->flow[0] = gain * (setpoint - last->level);
  *out = *last;
  state->write(self);
  return tank_pause_main;
}


/** Codel tank_control_halt of task control.
 *
 * Triggered by tank_stop.
 * Yields to tank_ether.
 * Throws tank_e_valve.
 */
/* Seeded: the specification calls it tank_control_stop. */
genom_event
tank_control_halt(const tank_reading *last, const genom_context self)
{
  (void)self;
  (void)last;
  return tank_ether;
}


/* --- Activity fill ---------------------------------------------------- */

/** Codel tank_fill_start of activity fill.
 *
 * Triggered by tank_start.
 * Yields to tank_wait.
 * Throws tank_e_valve.
 */
/* Seeded: the specification does not let it yield tank_ether. */
genom_event
tank_fill_start(double target, double *setpoint,
                const genom_context self)
{
  (void)self;
  if (target <= *setpoint) return tank_ether;
  *setpoint = target;
  return tank_wait;
}

/** Codel tank_fill_wait of activity fill.
 *
 * Triggered by tank_start.
 * Yields to tank_pause_wait, tank_ether.
 */
/* Seeded: the comment is of another time. */
genom_event
tank_fill_wait(double target, const tank_reading *last,
               const genom_context self)
{
  (void)self;
  return last->level < target ? tank_pause_wait : tank_ether;
}

/** Codel tank_fill_stop of activity fill.
 *
 * Triggered by tank_stop.
 * Yields to tank_ether.
 * Throws tank_e_valve.
 */
genom_event
tank_fill_stop(double *setpoint, const genom_context self)
{
  (void)self;
  *setpoint = 0.;
  return tank_ether;
}


/* --- Activity drain --------------------------------------------------- */

/** Codel tank_drain_start of activity drain.
 *
 * Triggered by tank_start.
 * Yields to tank_wait.
 * Throws tank_e_valve.
 */
genom_event
tank_drain_start(double until, double *setpoint,
                 const genom_context self)
{
  (void)self;
  *setpoint = until;
  return tank_wait;
}
