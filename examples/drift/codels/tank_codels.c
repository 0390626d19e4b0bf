/*
 * A water tank: a small component whose codels no longer follow the specification.
 */

#include "actank.h"

#include "tank_c_types.h"


/* --- Attribute set_gain ----------------------------------------------- */

/** Validation codel tank_check_gain of attribute set_gain.
 *
 * Returns genom_ok.
 * Throws tank_e_range.
 */
genom_event
tank_check_gain(double gain, const genom_context self)
{
  if (gain <= 0.) return tank_e_range(self);
  return genom_ok;
}


/* --- Activity fill ---------------------------------------------------- */

/** Validation codel tank_check_target of activity fill.
 *
 * Returns genom_ok.
 * Throws tank_e_valve.
 */
/* Seeded: `limit` is read only, and the specification throws no e_range here. */
genom_event
tank_check_target(double target, tank_reading *limit,
                  const genom_context self)
{
  if (target > limit->level) return tank_e_range(self);
  return genom_ok;
}


/* --- Function get_level ----------------------------------------------- */

/** Codel tank_get_level of function get_level.
 *
 * Returns genom_ok.
 */
/* Seeded: `flow` came later. */
genom_event
tank_get_level(const tank_reading *last, double *level,
               const genom_context self)
{
  (void)self;
  *level = last->level;
  return genom_ok;
}


/* --- Function mix ----------------------------------------------------- */

/** Codel tank_mix of function mix.
 *
 * Returns genom_ok.
 */
/* Seeded: another order. */
genom_event
tank_mix(double warm, double cold, double *result,
         const genom_context self)
{
  (void)self;
  *result = (warm + cold) / 2;
  return genom_ok;
}


/* --- Function reset_cycles -------------------------------------------- */

/** Codel tank_reset_cycles of function reset_cycles.
 *
 * Returns genom_ok.
 */
/* Seeded: `cycles` was a short, and the body still calls it so. */
genom_event
tank_reset_cycles(int16_t *cycles, const genom_context self)
{
  (void)self;
  *cycles = 0;
  return genom_ok;
}
